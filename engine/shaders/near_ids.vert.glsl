#version 450 core
#include "view.glsl"
#include "instance.glsl"

layout(location = 0) flat out uvec3 v_ids;
#ifdef SEE_THROUGH
layout(location = 1) out vec2 v_texcoord;
layout(location = 2) out float v_alpha;
#endif

void main() {
    gl_Position = clip_of(relative_position());
    v_ids = instance_names;
#ifdef SEE_THROUGH
    v_texcoord = texcoord;
    v_alpha = color.a;
#endif
}
