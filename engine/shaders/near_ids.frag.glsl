#version 450 core
// Which triangle of which instance covers the pixel; depth goes to the depth buffer.
#ifdef SEE_THROUGH
#include "view.glsl"
#include "material.glsl"
#include "surface_slope.glsl"
#include "alpha_test.glsl"
in vec2 v_texcoord;
in float v_alpha;
#endif
flat in uvec2 v_ids;
layout(location = 0) out uvec2 ids;

void main() {
#ifdef SEE_THROUGH
    float alpha = v_alpha * material.base_color.a;
    alpha *= caster_alpha(v_texcoord);
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    if (alpha < (material.emissive_cutoff.w >= 0.0 ? material.emissive_cutoff.w : hashed_threshold(v_ids.x, pixel)))
        discard;
#endif
    ids = uvec2(v_ids.x, v_ids.y + uint(gl_PrimitiveID));
}
