#pragma once
// What the things of the game are. Plain data; the systems beside this file change it.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "engine/ecs/entity.h"
#include "engine/math/types.h"
#include "engine/physics/types.h"
#include "engine/sound/sound_source.h"

namespace ff::beacons {

/// Where an entity was a tick ago: frames show what lies between.
struct Before {
    WorldPos position{0.0};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};
};

/// Where a walker last stood: who falls out of the world comes back to it.
struct Footing {
    WorldPos feet{0.0};
};

struct Beacon {
    std::uint32_t number = 0;     ///< 0 is the first
    std::uint32_t kindled = 0;    ///< ticks that somebody has held the torch to it
    std::uint32_t looked_at = 0;  ///< ticks that the spyglass has rested on it
    bool spotted = false;         ///< on the compass from now on
    bool lit = false;
};

/// Something that was heard; not part of what a session is.
struct SoundsHeard {
    std::vector<sound::SoundEvent> recent;  ///< of the last second
};

/// Follows a path of the world, there and back or round and round.
struct Traveller {
    std::uint32_t path = 0;   ///< of Paths
    double distance_m = 0.0;  ///< along it
    float speed_m_s = 1.0f;
    float bob_m = 0.0f;  ///< up and down, on water
};

/// Turns about its place when somebody uses it.
struct Gate {
    float open = 0.0f;  ///< [0, 1]
    bool opening = false;
    float swing_rad = 1.9f;
    double closed_yaw = 0.0;  ///< radians
};

}  // namespace ff::beacons
