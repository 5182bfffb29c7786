#pragma once
// A walking character: an upright capsule that is moved by sweeps, not by forces.

#include "engine/physics/types.h"

namespace ff::physics {

struct CharacterDesc {
    WorldPos position{0.0};           ///< of the feet
    float radius_m = 0.35f;           ///< [0.05, 5]
    float height_m = 1.8f;            ///< standing; [2 radius, 20]
    float crouch_height_m = 1.1f;     ///< [2 radius, height]
    float step_height_m = 0.4f;       ///< climbed without a jump, and followed down; [0, height / 2]
    float max_slope_rad = 0.87f;      ///< walked up to here, slid down beyond; [0, 1.5]
    float gravity_m_s2 = 9.81f;       ///< downwards; [0, 1000]
    float jump_height_m = 1.0f;       ///< of the feet above the ground; [0, 100]
    float ground_accel_m_s2 = 40.0f;  ///< towards the wished velocity; [0, 1e9]
    float air_accel_m_s2 = 8.0f;      ///< likewise, in the air; [0, 1e9]
    float max_fall_m_s = 60.0f;       ///< [0, 1e6]
    float push_force_n = 400.0f;      ///< on dynamic bodies in the way; [0, 1e6]
    float mass_kg = 75.0f;            ///< weighs on dynamic bodies it stands on; [0, 1e4]
    std::uint64_t user = 0;           ///< the caller's
};

/// What a player wants; holds until the next.
struct CharacterInput {
    Vec3 velocity_m_s{0.0f};  ///< wished, horizontal; y is not looked at. At most 1e6
    bool jump = false;        ///< from the ground; while held, again at every landing
    bool crouch = false;      ///< stands up again only where there is room
};

struct CharacterState {
    WorldPos position{0.0};  ///< of the feet
    Vec3 velocity_m_s{0.0f};
    Vec3 ground_normal{0.0f, 1.0f, 0.0f};
    BodyId ground;           ///< what it stands on; null: the static scene, or nothing
    bool on_ground = false;  ///< stands on what is no steeper than max_slope_rad
    bool crouching = false;
    float height_m = 0.0f;  ///< now
    std::uint64_t user = 0;
};

}  // namespace ff::physics
