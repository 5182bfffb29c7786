// Where a see-through triangle is there, by the rule of farfield/alpha_test.h: the nearest texel of the mip whose texels
// are as large as the ray's footprint. Needs view.glsl, material.glsl, surface_slope.glsl.

float caster_level(vec2 texcoord) {
    // The footprint in texels, squared, is uv area per metre^2 times (depth * pixel angle)^2 times texels; the screen
    // shows that area divided by the slope.
    vec2 gradient = vec2(dFdx(gl_FragCoord.w), dFdy(gl_FragCoord.w));
    Slope s = slope_of(ray_uv(gl_FragCoord.xy), gl_FragCoord.w, gradient);
    float texels = uv_area_per_pixel(texcoord) * s.slope * material.metallic_roughness.z;
    // No mip with less than 64 texels: it holds no coverage any more.
    ivec2 size = textureSize(base_color_nearest, 0);
    int last = max(0, findMSB(size.x) + findMSB(size.y) - 6) / 2;
    return min(floor(0.5 * log2(max(texels, 1.0))), float(last));
}

// Where the picture is looked up: foliage in the wind is moved.
#ifdef SWAYS
#include "leaf_sway.glsl"
#else
vec2 swayed(vec2 texcoord) {
    return texcoord;
}
#endif

float caster_alpha(vec2 texcoord) {
    return textureLod(base_color_nearest, swayed(texcoord), caster_level(texcoord)).a;
}

// Nearest texel along one side, as scene::wrap_texel. wrap: 0 repeat, 1 clamp, 2 mirror.
uint wrap_texel(float c, int size, int wrap) {
    if (wrap == 0) {
        c -= floor(c);
    } else if (wrap == 2) {
        c -= 2.0 * floor(0.5 * c);
        if (c > 1.0) c = 2.0 - c;
    }
    return uint(clamp(c * float(size), 0.0, float(size - 1)));
}

// What names the hashed threshold beside the triangle: the texel, or without a texture a 64th of the triangle.
uvec2 caster_texel(vec2 texcoord, vec2 barycentrics) {
    int wraps = int(material.metallic_roughness.w);  // -1 without a texture
    if (wraps < 0) return uvec2(wrap_texel(barycentrics.x, 64, 1), wrap_texel(barycentrics.y, 64, 1));
    int level = int(caster_level(texcoord));
    ivec2 size = textureSize(base_color_nearest, level);
    return uvec2(wrap_texel(texcoord.x, size.x, wraps % 3), wrap_texel(texcoord.y, size.y, wraps / 3));
}

// Texel i along one side, which may lie one beyond either end. Sizes are powers of two.
int wrap_index(int i, int size, int wrap) {
    if (wrap == 0) return i & (size - 1);
    if (wrap == 1) return clamp(i, 0, size - 1);
    int phase = i & (2 * size - 1);
    return min(phase, 2 * size - 1 - phase);
}

// Whether the four texels around the point have an alpha of 1: is_solid_at() of farfield/alpha_test.h.
bool caster_is_filled(vec2 texcoord) {
    int wraps = int(material.metallic_roughness.w);
    if (wraps < 0) return true;
    int level = int(caster_level(texcoord));
    ivec2 size = textureSize(base_color_nearest, level), wrap = ivec2(wraps % 3, wraps / 3);
    vec2 c = texcoord;
    for (int axis = 0; axis < 2; ++axis) {
        if (wrap[axis] == 0) c[axis] -= floor(c[axis]);
        else if (wrap[axis] == 1) c[axis] = clamp(c[axis], 0.0, 1.0);
        else c[axis] -= 2.0 * floor(0.5 * c[axis]);
    }
    ivec2 first = ivec2(floor(c * vec2(size) - 0.5));
    float least = 1.0;
    for (int corner = 0; corner < 4; ++corner) {
        ivec2 i = first + ivec2(corner & 1, corner >> 1);
        ivec2 texel = ivec2(wrap_index(i.x, size.x, wrap.x), wrap_index(i.y, size.y, wrap.y));
        least = min(least, texelFetch(base_color_nearest, texel, level).a);
    }
    return least == 1.0;
}

// (0, 1], the same every time, and for every caster, for a texel of a triangle.
float hashed_threshold(uint instance, uint triangle, uvec2 texel) {
    uint seed = instance * 0xC2B2AE3Du + triangle * 0x27D4EB2Fu;
    uint h = seed ^ (texel.x * 0x9E3779B1u) ^ (texel.y * 0x85EBCA77u);
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    h ^= h >> 15;
    return float((h >> 8) + 1u) * (1.0 / 16777216.0);
}
