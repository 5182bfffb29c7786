// The view of the frame, as nearfield/view_uniforms.h fills it. Positions are relative to the camera, world axes.
layout(std140, binding = 0) uniform View {
    vec4 clip_x;
    vec4 clip_y;
    vec4 clip_w;  // w: near plane
    vec4 right;   // w: u_step
    vec4 up;      // w: v_step
    vec4 back;    // w: pixel angle
    vec4 first;   // x: u_first, y: v_first, z: blended surfaces nearer than this are transparent layers, metres;
                  // w: leaves nearer than this move, 0: none does
    vec4 gust;    // trains of the wind in leaves (leaf_sway.glsl): turns per metre, w: turns at the eye
    vec4 sway_u;
    vec4 sway_v;
    vec4 leaves;  // x: amplitude, metres
} view;

// Reversed depth with an infinite far plane; y grows downwards.
vec4 clip_of(vec3 p) {
    return vec4(dot(view.clip_x.xyz, p), dot(view.clip_y.xyz, p), view.clip_w.w, dot(view.clip_w.xyz, p));
}

// (u, v) of the fragment's ray (u, v, -1) in camera space.
vec2 ray_uv(vec2 frag_coord) {
    return frag_coord * vec2(view.right.w, view.up.w) + view.first.xy;
}

vec3 world_direction(vec2 uv) {
    return view.right.xyz * uv.x + view.up.xyz * uv.y - view.back.xyz;
}
