#version 450 core
// Tells fragments where in the triangle they are: without a texture, the hashed threshold of a blended one is named by
// its barycentrics.
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

layout(location = 0) flat in uvec3 v_ids[];
layout(location = 1) in vec2 v_texcoord[];
layout(location = 2) in float v_alpha[];
layout(location = 0) flat out uvec3 g_ids;
layout(location = 1) out vec2 g_texcoord;
layout(location = 2) out float g_alpha;
layout(location = 3) out vec2 g_barycentrics;  // of corners 1 and 2

void main() {
    for (int corner = 0; corner < 3; ++corner) {
        gl_Position = gl_in[corner].gl_Position;
        gl_PrimitiveID = gl_PrimitiveIDIn;
        g_ids = v_ids[corner];
        g_texcoord = v_texcoord[corner];
        g_alpha = v_alpha[corner];
        g_barycentrics = vec2(corner == 1, corner == 2);
        EmitVertex();
    }
}
