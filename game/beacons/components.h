#pragma once
// What the things of the game are. Plain data; the systems beside this file change it.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>

#include "engine/ecs/entity.h"
#include "engine/math/types.h"
#include "engine/physics/types.h"

namespace ff::beacons {

/// Meshes of the world that show an entity: some of WorldInfo::dynamic_instances, where its transform puts them.
struct Model {
    std::uint32_t first_instance = 0, instance_count = 0;
    std::uint32_t first_animated = 0, animated_count = 0;  ///< likewise, of AnimationSet::instances
    WorldPos placed_at{0.0};                               ///< where the world has them
    glm::quat placed_turn{1.0f, 0.0f, 0.0f, 0.0f};
};

/// Where an entity was a tick ago: frames show what lies between.
struct Before {
    WorldPos position{0.0};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};
};

struct Beacon {
    std::uint32_t number = 0;     ///< 0 is the first
    std::uint32_t kindled = 0;    ///< ticks that somebody has held the torch to it
    std::uint32_t looked_at = 0;  ///< ticks that the spyglass has rested on it
    bool spotted = false;         ///< on the compass from now on
    bool lit = false;
};

/// Follows a path of the world, there and back or round and round.
struct Traveller {
    std::uint32_t path = 0;   ///< of Paths
    double distance_m = 0.0;  ///< along it
    float speed_m_s = 1.0f;
    float bob_m = 0.0f;  ///< up and down, on water
};

/// One of a flock.
struct Bird {
    Vec3 velocity_m_s{0.0f};
    std::uint32_t flock = 0;
};

/// Turns about its place when somebody uses it.
struct Gate {
    float open = 0.0f;  ///< [0, 1]
    bool opening = false;
    float swing_rad = 1.9f;
    double closed_yaw = 0.0;  ///< radians
};

}  // namespace ff::beacons
