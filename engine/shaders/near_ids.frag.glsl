#version 450 core
// Which triangle of which instance covers the pixel; depth goes to the depth buffer.
layout(location = 0) flat in uvec3 v_ids;
#ifdef SEE_THROUGH
#include "view.glsl"
#include "material.glsl"
#include "surface_slope.glsl"
#include "alpha_test.glsl"
layout(location = 1) in vec2 v_texcoord;
layout(location = 2) in float v_alpha;
#endif
#ifdef BLENDED
layout(location = 3) in vec2 v_barycentrics;
layout(std430, binding = 0) readonly buffer TriangleNames {
    uint scene_triangles[];  // by GPU order, of the meshes that were put in another (nearfield/mesh_layout.h)
};
#endif
layout(location = 0) out uvec2 ids;

void main() {
    uint triangle = v_ids.y + uint(gl_PrimitiveID);
#ifdef SEE_THROUGH
    float alpha = v_alpha * material.base_color.a * caster_alpha(v_texcoord);
#ifdef BLENDED
    uint name = v_ids.z == 0xFFFFFFFFu ? triangle : scene_triangles[v_ids.z + triangle];
    float cutoff = hashed_threshold(v_ids.x, name, caster_texel(v_texcoord, v_barycentrics));
#else
    float cutoff = material.emissive_cutoff.w;
#endif
#ifdef BLENDED
    // Of a transparent layer only what is solid.
    bool in_layer = length(vec3(ray_uv(gl_FragCoord.xy), 1.0)) < view.first.z * gl_FragCoord.w;
    if (in_layer) {
        if (v_alpha * material.base_color.a <= 1.0 - 0.5 / 255.0 || !caster_is_filled(v_texcoord)) discard;
    } else
#endif
    if (alpha < cutoff) discard;
#endif
    ids = uvec2(v_ids.x, triangle);
}
