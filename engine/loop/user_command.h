#pragma once

#include <cstdint>

namespace ff::loop {

/// All that one tick learns of the player: what a recording holds, and nothing else reaches the simulation.
struct UserCommand {
    static constexpr int kFull = 127;

    std::int8_t move_right = 0, move_ahead = 0;  ///< share of full speed, in 1 / kFull; negative: left, back
    std::int32_t yaw_urad = 0;                   ///< where the player looks, microradians, as Camera::yaw
    std::int32_t pitch_urad = 0;                 ///< likewise; within straight up and down
    std::uint16_t buttons = 0;                   ///< held during the tick; bit i: the game's action i

    [[nodiscard]] bool held(int action) const { return ((buttons >> action) & 1) != 0; }
    friend bool operator==(const UserCommand&, const UserCommand&) = default;
};

}  // namespace ff::loop
