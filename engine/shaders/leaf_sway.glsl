// leaf_shift() of math/leaf_sway.h. Needs view.glsl, material.glsl, surface_slope.glsl.

float turn_sine(float turns) {
    float t = turns - floor(turns + 0.5);
    return 8.0 * t * (1.0 - 2.0 * abs(t));
}

// Where the fragment's picture is looked up.
vec2 swayed(vec2 texcoord) {
    float within = view.first.w * material.foliage.x;  // a program is shared by what sways and what does not
    if (within == 0.0) return texcoord;
    vec2 gradient = vec2(dFdx(gl_FragCoord.w), dFdy(gl_FragCoord.w));
    Slope s = slope_of(ray_uv(gl_FragCoord.xy), gl_FragCoord.w, gradient);
    float uv_per_m = sqrt(uv_area_per_pixel(texcoord) * s.slope) * gl_FragCoord.w / view.back.w;
    vec3 p = world_direction(ray_uv(gl_FragCoord.xy)) / gl_FragCoord.w;
    float fade = clamp((1.0 - length(p) / within) / 0.4, 0.0, 1.0);
    float gust = 0.65 + 0.35 * turn_sine(view.gust.w + dot(view.gust.xyz, p));
    vec2 f = texcoord - floor(texcoord);
    vec2 window = 4.0 * f * (1.0 - f);
    float size = fade * gust * min(view.leaves.x * uv_per_m, 0.1) * window.x * window.y;
    return texcoord + size * vec2(turn_sine(view.sway_u.w + dot(view.sway_u.xyz, p)),
                                  turn_sine(view.sway_v.w + dot(view.sway_v.xyz, p)));
}
