// What vertex shaders read: a vertex, and the record of its instance (nearfield/draw_list.h).
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 normal_oct;
layout(location = 2) in vec2 texcoord;
layout(location = 3) in vec4 color;
layout(location = 4) in vec4 relative_row0;
layout(location = 5) in vec4 relative_row1;
layout(location = 6) in vec4 relative_row2;
layout(location = 7) in uvec3 instance_names;  // instance, first triangle of the range, first of its names

vec3 relative_position() {
    vec4 p = vec4(position, 1.0);
    return vec3(dot(relative_row0, p), dot(relative_row1, p), dot(relative_row2, p));
}

// Inverse transpose up to scale: cofactors, which keep their sense under mirroring as the casters' normals do.
vec3 relative_normal() {
    vec3 n = vec3(normal_oct, 1.0 - abs(normal_oct.x) - abs(normal_oct.y));
    float fold = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.y += n.y >= 0.0 ? -fold : fold;
    vec3 a = relative_row0.xyz, b = relative_row1.xyz, c = relative_row2.xyz;
    return vec3(dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n));
}
