#pragma once

#include "engine/math/camera.h"
#include "engine/platform/input.h"

namespace ff::loop {

struct FreeCameraSettings {
    double walk_m_s = 4.0;             ///< metres a second
    double run_factor = 8.0;           ///< while shift is held, or the right trigger is
    double mouse_radians_px = 0.0025;  ///< of turn per pixel of mouse movement
    double stick_radians_s = 2.5;      ///< of turn per second at full tilt
    double key_radians_s = 1.5;        ///< of turn per second by the arrow keys
};

/// Moves a camera by what the player did: WASD and the left stick walk level, E and Q rise and sink, mouse, arrow keys
/// and the right stick look; shift runs. Pitch stays within straight up and down, yaw within a turn.
/// @param dt_s  seconds since the last call; clamped to [0, 0.1], so that a hiccup is not a leap
void move_free_camera(const platform::InputState& input, double dt_s, const FreeCameraSettings& settings,
                      Camera& camera);

}  // namespace ff::loop
