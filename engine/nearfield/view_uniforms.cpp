#include "engine/nearfield/view_uniforms.h"

namespace ff::nearfield {

ViewUniforms make_view_uniforms(const PinholeView& view) {
    const Vec3 right = view.world_from_camera[0], up = view.world_from_camera[1], back = view.world_from_camera[2];
    // Pixel column x (continuous) of a point is (u - u_first) / u_step, u = x_camera / depth; clip.x / w runs from -1
    // at column 0 to 1 at column `width`. Rows likewise, growing downwards.
    const float scale_x = 2.0f / (view.u_step * float(view.width));
    const float scale_y = 2.0f / (view.v_step * float(view.height));
    const float shift_x = -view.u_first * scale_x - 1.0f, shift_y = -view.v_first * scale_y - 1.0f;
    ViewUniforms uniforms;
    uniforms.clip_x = Vec4(scale_x * right - shift_x * back, 0.0f);
    uniforms.clip_y = Vec4(scale_y * up - shift_y * back, 0.0f);
    uniforms.clip_w = Vec4(-back, kNearPlaneM);
    uniforms.right = Vec4(right, view.u_step);
    uniforms.up = Vec4(up, view.v_step);
    uniforms.back = Vec4(back, view.pixel_angle());
    uniforms.first = Vec4(view.u_first, view.v_first, view.blend_within_m, view.sway.within_m);
    const auto train = [](const LeafSway::Train& t) { return Vec4(t.turns_per_m, t.turns); };
    uniforms.gust = train(view.sway.gust);
    uniforms.sway_u = train(view.sway.along_u);
    uniforms.sway_v = train(view.sway.along_v);
    uniforms.leaves = Vec4(view.sway.amplitude_m, 0.0f, 0.0f, 0.0f);
    return uniforms;
}

}  // namespace ff::nearfield
