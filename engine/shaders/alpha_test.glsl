// Where a see-through triangle is there, by the rule of farfield/alpha_test.h: the nearest texel of the mip whose texels
// are as large as the ray's footprint. Needs view.glsl, material.glsl, surface_slope.glsl.

float caster_alpha(vec2 texcoord) {
    // The footprint in texels, squared, is uv area per metre^2 times (depth * pixel angle)^2 times texels; the screen
    // shows that area divided by the slope.
    vec2 gradient = vec2(dFdx(gl_FragCoord.w), dFdy(gl_FragCoord.w));
    Slope s = slope_of(ray_uv(gl_FragCoord.xy), gl_FragCoord.w, gradient);
    float texels = uv_area_per_pixel(texcoord) * s.slope * material.metallic_roughness.z;
    return textureLod(base_color_nearest, texcoord, floor(0.5 * log2(max(texels, 1.0)))).a;
}

// (0, 1], the same every time for an instance and a pixel.
float hashed_threshold(uint instance, uvec2 pixel) {
    uint h = (instance * 0xC2B2AE3Du) ^ (pixel.x * 0x9E3779B1u) ^ (pixel.y * 0x85EBCA77u);
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    h ^= h >> 15;
    return float((h >> 8) + 1u) * (1.0 / 16777216.0);
}
