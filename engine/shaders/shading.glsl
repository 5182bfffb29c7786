// The shading model for the rasteriser: the same formulas and constants as engine/shading/shading_model.h and
// shading_kernel.cpp, so that the border of near and far cannot be seen (within 2/255). README.md says what the program
// that includes it must do. Colours are linear RGB unless said otherwise.

// ff::shading::ShadingUniforms
layout(std140, binding = 1) uniform Shading {
    vec4 to_sun;         // w: fog density per metre
    vec4 sun_radiance;   // w: pixel angle squared
    vec4 ambient_side;   // light on a surface by its normal's height y: side + y * slope + y^2 * curve
    vec4 ambient_slope;
    vec4 ambient_curve;
    vec4 horizon;
    vec4 zenith;
    vec4 haze;
    vec4 panorama_size;  // xy: texels, 0 without one; z: 1 with an atmosphere; w: shown by film
    vec4 sunward;        // xz: unit, level, towards the sun's azimuth
    vec4 night;
    vec4 air;            // xyz: Rayleigh extinction per metre at the eye
    vec4 haze_air;       // xyz: haze's and fog's
    vec4 sky_rows[128];  // scene::SkyTable: rayleigh, rayleigh_sunward, mie, mie_sunward; w: scattered again
} shading;
// GL_RGBA16F, one level, GL_LINEAR, GL_REPEAT in s, GL_CLAMP_TO_EDGE in t, the zenith's row first. Any texture where the
// scene has none.
layout(binding = 4) uniform sampler2D sky_panorama;

const float kPi = 3.14159265358979;
const float kSoftClipStart = 0.6;
const float kSoftClipScale = 0.25 / (1.0 - kSoftClipStart);
const float kFilmColor = 1.15;
const float kHazeRate = 8.0;
const float kSunGlowWide = 0.06;
const float kSunGlowNarrow = 0.20;
const float kSunDisc = 4.0;
const float kSunDiscEdge = 0.99988;
const float kSunDiscFull = 0.99997;
const int kSkyRows = 32;
const float kHazeSquare = 1.5776;
const float kHazeTwice = 1.52;
const float kRayleighHeightM = 8000.0;
const float kMieHeightM = 1200.0;
const float kMaxAirHeights = 8.0;
const float kDielectric = 0.04;
const float kMinRoughness = 0.08;

// A point of a surface, ready to be lit.
struct SurfaceInput {
    vec3 base_color;  // factor, texture and vertex colour
    vec3 emissive;
    vec3 normal;      // unit, world axes, turned to the viewer's side of the triangle's plane
    vec3 to_eye;      // unit; shade_specular only, as the next two
    float metallic;
    float roughness;
};

// Encoded sRGB to linear, 0..1.
vec3 decode_srgb(vec3 c) {
    return c * (0.0664250691 + c * (0.195165952 + c * (1.76834260 + c * (-1.77607619 + c * 0.749894059))));
}

// Linear to encoded sRGB, 0..1; write it to a target without GL_FRAMEBUFFER_SRGB.
vec3 encode_srgb(vec3 color) {
    vec3 x = clamp(color, 0.0, 1.0);
    vec3 s = sqrt(x);
    vec3 bright = -0.0370060697 + s * (1.44790652 + s * (-0.944849486 + s * (0.842726083 + s * -0.309520361)));
    return mix(bright, 12.92 * x, lessThan(x, vec3(0.0031308)));
}

// Likewise, as pictures of an atmosphere are shown.
vec3 encode_film(vec3 color) {
    float luminance = dot(color, vec3(0.2126, 0.7152, 0.0722));
    vec3 s = sqrt(clamp(mix(vec3(luminance), color, kFilmColor), 0.0, 1.0));
    return 0.0 + s * (0.495170 + s * (4.059123 + s * (-6.399927 + s * 2.845635)));
}

vec3 encode_color(vec3 color) {
    return shading.panorama_size.w > 0.0 ? encode_film(color) : encode_srgb(color);
}

vec3 soft_clip(vec3 x) {
    vec3 bent = clamp(x - kSoftClipStart, 0.0, 2.0 * (1.0 - kSoftClipStart));
    return min(x, 2.0 - kSoftClipStart) - bent * bent * kSoftClipScale;
}

// Sun and sky on a white diffuse surface.
vec3 diffuse_light(float normal_y, float sun_cosine) {
    vec3 sky = shading.ambient_side.rgb + normal_y * (shading.ambient_slope.rgb + normal_y * shading.ambient_curve.rgb);
    return sky + max(sun_cosine, 0.0) * shading.sun_radiance.rgb;
}

// The sky without sun at a unit direction's height.
vec3 sky_gradient(float y) {
    float up = max(y, 0.0);
    float down = min(max(-y, 0.0) * kHazeRate, 1.0);
    vec3 sky = mix(shading.horizon.rgb, shading.zenith.rgb, up * (2.0 - up));
    return mix(sky, shading.haze.rgb, down * (2.0 - down));
}

// direction: unit, world axes.
vec3 gradient_sky(vec3 direction) {
    float cosine = max(dot(direction, shading.to_sun.xyz), 0.0);
    float wide = cosine * cosine;
    wide *= wide;
    wide *= wide;  // cos^8
    float narrow = wide * wide;
    narrow *= narrow;
    narrow *= narrow;
    narrow *= narrow;  // cos^128
    float disc = clamp((cosine - kSunDiscEdge) / (kSunDiscFull - kSunDiscEdge), 0.0, 1.0);
    float sun = kSunGlowWide * wide + kSunGlowNarrow * narrow + kSunDisc * disc * disc;
    sun *= clamp(1.0 + direction.y * kHazeRate, 0.0, 1.0);
    return sky_gradient(direction.y) + sun * shading.sun_radiance.rgb;
}

// The light of two rows of the sky's table, t of the way between them; without sun and night. direction: unit.
vec3 light_of_rows(int a, int b, float t, vec3 direction) {
    float level = dot(direction, shading.sunward.xyz);
    float cosine = dot(direction, shading.to_sun.xyz);
    vec4 rayleigh = mix(shading.sky_rows[4 * a], shading.sky_rows[4 * b], t);
    vec4 rayleigh_sunward = mix(shading.sky_rows[4 * a + 1], shading.sky_rows[4 * b + 1], t);
    vec4 mie = mix(shading.sky_rows[4 * a + 2], shading.sky_rows[4 * b + 2], t);
    vec4 mie_sunward = mix(shading.sky_rows[4 * a + 3], shading.sky_rows[4 * b + 3], t);
    float root = inversesqrt(kHazeSquare - kHazeTwice * cosine);
    return (rayleigh.rgb + level * rayleigh_sunward.rgb) * (1.0 + cosine * cosine) +
           (mie.rgb + level * mie_sunward.rgb) * (root * root * root) +
           vec3(rayleigh.w, rayleigh_sunward.w, mie.w) * (1.0 + level * mie_sunward.w);
}

// How bright the air's light shows: what is dark as it is, what is very bright saturates.
vec3 shown_air(vec3 light) {
    return 1.0 - exp(-light * (1.0 + 0.5 * light));
}

// The sky without the sun's disc. direction: unit.
vec3 atmosphere_light(vec3 direction) {
    float at = sqrt(clamp(direction.y, 0.0, 1.0)) * float(kSkyRows - 1);
    int below = min(int(at), kSkyRows - 2);
    vec3 sky = shown_air(light_of_rows(below, below + 1, at - float(below), direction) + shading.night.rgb);
    float down = min(max(-direction.y, 0.0) * kHazeRate, 1.0);
    return mix(sky, shading.haze.rgb, down * (2.0 - down));
}

// direction: unit.
vec3 atmosphere_sky(vec3 direction) {
    float cosine = dot(direction, shading.to_sun.xyz);
    float disc = clamp((cosine - kSunDiscEdge) / (kSunDiscFull - kSunDiscEdge), 0.0, 1.0);
    float sun = kSunDisc * disc * disc * clamp(1.0 + direction.y * kHazeRate, 0.0, 1.0);
    return atmosphere_light(direction) + sun * shading.sun_radiance.rgb;
}

// Mean of exp(-x) from 0 to x: density along a ray that climbs x scale heights, over that where it starts.
float mean_density(float x) {
    x = clamp(x, -kMaxAirHeights, kMaxAirHeights);
    if (abs(x) < 0.05) return 1.0 + x * (x / 6.0 - 0.5);
    return (1.0 - exp(-x)) / x;
}

// A surface's colour behind the atmosphere. direction: unit.
vec3 behind_air(vec3 color, float distance_m, vec3 direction) {
    vec3 air = shown_air(light_of_rows(0, 0, 0.0, direction) + shading.night.rgb);
    float climb = distance_m * direction.y;
    vec3 depth = distance_m * (shading.air.rgb * mean_density(climb / kRayleighHeightM) +
                               shading.haze_air.rgb * mean_density(climb / kMieHeightM));
    return mix(air, color, exp(-depth));
}

// direction: unit, world axes.
vec3 sky_color(vec3 direction) {
    if (shading.panorama_size.z > 0.0) return atmosphere_sky(direction);
    if (shading.panorama_size.x == 0.0) return gradient_sky(direction);
    float azimuth = atan(direction.x, -direction.z);
    float polar = atan(length(direction.xz), direction.y);
    return textureLod(sky_panorama, vec2(azimuth / (2.0 * kPi), polar / kPi), 0.0).rgb;
}

// Sun: GGX, Smith height-correlated, Schlick. Sky: mirrored gradient, Karis' fit of the split sum.
vec3 specular_surface(vec3 normal, vec3 to_eye, vec3 color, float metallic, float roughness) {
    vec3 sun = shading.to_sun.xyz;
    float sun_cosine = dot(normal, sun);
    float n_l = max(sun_cosine, 0.0);
    float n_v = max(dot(normal, to_eye), 1e-4);
    vec3 half_way = sun + to_eye;
    half_way *= inversesqrt(max(dot(half_way, half_way), 1e-36));
    float n_h = clamp(dot(normal, half_way), 0.0, 1.0);
    float v_h = clamp(dot(to_eye, half_way), 0.0, 1.0);
    float rough = clamp(roughness, kMinRoughness, 1.0);
    float metal = clamp(metallic, 0.0, 1.0);

    float alpha = rough * rough;
    float alpha2 = alpha * alpha;
    float base = n_h * n_h * (alpha2 - 1.0) + 1.0;
    float smith = n_l * sqrt(n_v * n_v * (1.0 - alpha2) + alpha2) + n_v * sqrt(n_l * n_l * (1.0 - alpha2) + alpha2);
    float lobe = 0.5 * alpha2 * n_l / max(base * base * smith, 1e-9);
    float grazing = 1.0 - v_h;
    float grazing2 = grazing * grazing;
    vec3 f0 = mix(vec3(kDielectric), color, metal);
    vec3 fresnel = mix(f0, vec3(1.0), grazing2 * grazing2 * grazing);
    vec3 lit = (1.0 - metal) * color * diffuse_light(normal.y, sun_cosine);
    lit += lobe * fresnel * shading.sun_radiance.rgb;

    vec3 mirrored_way = 2.0 * n_v * normal - to_eye;
    float mirrored_y = mirrored_way.y;
    vec3 sharp = shading.panorama_size.z > 0.0 ? atmosphere_light(mirrored_way) : sky_gradient(mirrored_y);
    vec3 mirrored = mix(sharp, diffuse_light(mirrored_y, 0.0), rough);
    float r0 = 1.0 - rough;
    float a004 = min(r0 * r0, exp2(-9.28 * n_v)) * r0 + (0.0425 - 0.0275 * rough);
    vec2 fit = vec2(-1.04, 1.04) * a004 + vec2(1.04 - 0.572 * rough, 0.022 * rough - 0.04);
    return lit + mirrored * (f0 * fit.x + fit.y);
}

// Before fog; so are the next.
vec3 shade_diffuse(SurfaceInput s) {
    return soft_clip(s.base_color * diffuse_light(s.normal.y, dot(s.normal, shading.to_sun.xyz)) + s.emissive);
}

vec3 shade_specular(SurfaceInput s) {
    return soft_clip(specular_surface(s.normal, s.to_eye, s.base_color, s.metallic, s.roughness) + s.emissive);
}

vec3 shade_unlit(SurfaceInput s) {
    return s.base_color + s.emissive;
}

vec3 add_fog(vec3 color, float distance_m) {
    return mix(shading.horizon.rgb, color, exp(-shading.to_sun.w * distance_m));
}
