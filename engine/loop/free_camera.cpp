#include "engine/loop/free_camera.h"

#include <algorithm>
#include <cmath>

namespace ff::loop {

using platform::Key;

void move_free_camera(const platform::InputState& input, double dt_s, const FreeCameraSettings& settings,
                      Camera& camera) {
    const double dt = std::clamp(std::isfinite(dt_s) ? dt_s : 0.0, 0.0, 0.1);
    const auto axis = [&](Key positive, Key negative) {
        return double(input.held(positive)) - double(input.held(negative));
    };

    camera.yaw +=
        settings.mouse_radians_px * input.mouse_dx +
        dt * (settings.key_radians_s * axis(Key::right, Key::left) + settings.stick_radians_s * input.gamepad.right_x);
    camera.pitch -=
        settings.mouse_radians_px * input.mouse_dy +
        dt * (settings.key_radians_s * axis(Key::down, Key::up) + settings.stick_radians_s * input.gamepad.right_y);
    camera.yaw = std::remainder(camera.yaw, 2.0 * kPi);
    camera.pitch = std::clamp(camera.pitch, -0.5 * kPi, 0.5 * kPi);

    const double right = axis(Key::d, Key::a) + input.gamepad.left_x;
    const double ahead = axis(Key::w, Key::s) - input.gamepad.left_y;
    const double rise = axis(Key::e, Key::q);
    const bool runs = input.held(Key::left_shift) || input.held(Key::right_shift) || input.gamepad.right_trigger > 0.5f;
    const double step = dt * settings.walk_m_s * (runs ? settings.run_factor : 1.0);
    const double sin_yaw = std::sin(camera.yaw), cos_yaw = std::cos(camera.yaw);
    camera.position += step * DVec3(right * cos_yaw + ahead * sin_yaw, rise, right * sin_yaw - ahead * cos_yaw);
}

}  // namespace ff::loop
