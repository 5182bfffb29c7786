#version 450 core
#include "view.glsl"
#include "instance.glsl"

out vec3 v_normal;
out vec2 v_texcoord;
#ifdef VERTEX_COLOR
out vec4 v_color;
#endif

void main() {
    gl_Position = clip_of(relative_position());
    v_normal = relative_normal();
    v_texcoord = texcoord;
#ifdef VERTEX_COLOR
    v_color = color;
#endif
}
