#version 450 core
#include "view.glsl"
#include "shading.glsl"
layout(location = 0) out vec4 color;

void main() {
    color = vec4(encode_color(sky_color(normalize(world_direction(ray_uv(gl_FragCoord.xy))))), 1.0);
}
