#version 450 core
#include "view.glsl"
#include "instance.glsl"

flat out uvec2 v_ids;
#ifdef SEE_THROUGH
out vec2 v_texcoord;
out float v_alpha;
#endif

void main() {
    gl_Position = clip_of(relative_position());
    v_ids = instance_and_first_triangle;
#ifdef SEE_THROUGH
    v_texcoord = texcoord;
    v_alpha = color.a;
#endif
}
