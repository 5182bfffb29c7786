// What the screen's neighbours tell of the triangle under a fragment. needs view.glsl.
//
// 1 / depth is linear on the screen: q = dot(n, d) / plane for the ray d = (u, v, -1), n the unit normal and plane its
// distance. So q and its two derivatives give n / plane, and with it the slope dot(n, d) that texture footprints need.
struct Slope {
    vec3 normal;      // unit, camera space, towards the viewer
    float slope;      // |dot(unit normal, d)|
};

Slope slope_of(vec2 uv, float inverse_depth, vec2 inverse_depth_gradient) {
    float qu = inverse_depth_gradient.x / view.right.w, qv = inverse_depth_gradient.y / view.up.w;
    vec3 n = vec3(qu, qv, uv.x * qu + uv.y * qv - inverse_depth);
    float scale = inversesqrt(max(dot(n, n), 1e-38));
    Slope s;
    s.normal = -n * scale;
    s.slope = max(inverse_depth * scale, 1e-6);
    return s;
}

// uv^2 under one pixel, by neighbours.
float uv_area_per_pixel(vec2 texcoord) {
    vec2 dx = dFdx(texcoord), dy = dFdy(texcoord);
    return abs(dx.x * dy.y - dx.y * dy.x);
}
