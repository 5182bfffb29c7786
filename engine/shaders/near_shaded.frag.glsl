#version 450 core
// A surface, shaded by the model that all of the engine shares.
#include "view.glsl"
#include "material.glsl"
#include "surface_slope.glsl"
#include "alpha_test.glsl"
#include "shading.glsl"

in vec3 v_normal;
in vec2 v_texcoord;
#ifdef VERTEX_COLOR
in vec4 v_color;
#endif
layout(location = 0) out vec4 color;

void main() {
    vec2 uv = ray_uv(gl_FragCoord.xy);
    vec2 gradient = vec2(dFdx(gl_FragCoord.w), dFdy(gl_FragCoord.w));
    Slope surface = slope_of(uv, gl_FragCoord.w, gradient);
    float ray_length = length(vec3(uv, 1.0));

    vec4 base = material.base_color;
#ifdef VERTEX_COLOR
    base *= v_color;
#endif
#if defined(BASE_TEXTURE) || defined(EMISSIVE_TEXTURE) || defined(ROUGHNESS_TEXTURE)
    // The shading model's footprint: uv^2 that the ray cone covers, its long axis shortened. It is (width / cosine)^2 *
    // density * sqrt(slope); the screen shows density * (depth * pixel angle)^2 / slope.
    float footprint = uv_area_per_pixel(v_texcoord) * ray_length * ray_length * inversesqrt(surface.slope);
    #define LOD(map) (0.5 * log2(max(footprint * float(textureSize(map, 0).x * textureSize(map, 0).y), 1e-30)))
#endif
#ifdef BASE_TEXTURE
    vec4 texel = textureLod(base_color_texture, swayed(v_texcoord), LOD(base_color_texture));
    base *= vec4(decode_srgb(texel.rgb), texel.a);
#endif
#ifdef ALPHA_MASK
    float alpha = material.base_color.a;
#ifdef VERTEX_COLOR
    alpha *= v_color.a;
#endif
#ifdef BASE_TEXTURE
    alpha *= caster_alpha(v_texcoord);
#endif
    if (alpha < material.emissive_cutoff.w) discard;
#endif

    SurfaceInput s;
    s.base_color = base.rgb;
    s.emissive = material.emissive_cutoff.rgb;
#ifdef EMISSIVE_TEXTURE
    s.emissive *= decode_srgb(textureLod(emissive_texture, v_texcoord, LOD(emissive_texture)).rgb);
#endif
    vec3 facing = view.right.xyz * surface.normal.x + view.up.xyz * surface.normal.y + view.back.xyz * surface.normal.z;
    vec3 normal = dot(v_normal, facing) < 0.0 ? -v_normal : v_normal;
    s.normal = normalize(normal);
#ifdef UNLIT
    vec3 shaded = shade_unlit(s);
#elif defined(SPECULAR)
    s.metallic = material.metallic_roughness.x;
    s.roughness = material.metallic_roughness.y;
#ifdef ROUGHNESS_TEXTURE
    vec2 map = textureLod(metallic_roughness_texture, v_texcoord, LOD(metallic_roughness_texture)).gb;
    s.roughness *= map.x;
    s.metallic *= map.y;
#endif
    s.to_eye = -world_direction(uv) / ray_length;
    vec3 shaded = shade_specular(s);
#else
    vec3 shaded = shade_diffuse(s);
#endif
#ifdef AIR
    if (shading.panorama_size.z > 0.0)
        shaded = behind_air(shaded, ray_length / gl_FragCoord.w, world_direction(uv) / ray_length);
    else
        shaded = add_fog(shaded, ray_length / gl_FragCoord.w);
#elif defined(FOG)
    shaded = add_fog(shaded, ray_length / gl_FragCoord.w);
#endif
    color.rgb = encode_color(shaded);
#ifdef BLEND
    color.a = base.a;
#else
    color.a = 1.0;
#endif
}
