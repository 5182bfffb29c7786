#pragma once
// Flocks: each bird keeps with its neighbours, apart from them, and near its place.
//
// Based on: Reynolds, "Flocks, Herds, and Schools: A Distributed Behavioral Model", SIGGRAPH 1987.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <span>
#include <vector>

#include "engine/ecs/schedule.h"
#include "engine/ecs/transform_hierarchy.h"
#include "engine/math/camera.h"
#include "engine/scene/world.h"

namespace ff::scenery {

/// One of a flock, on an entity with a LocalTransform.
struct Bird {
    Vec3 velocity_m_s{0.0f};
    std::uint32_t flock = 0;  ///< of Flocks::homes
};

/// Resource: where flocks live, and who looks at them.
struct Flocks {
    struct Home {
        WorldPos position{0.0};
        float radius_m = 45.0f;
    };
    std::vector<Home> homes;
    WorldPos viewer{0.0};
    double vertical_fov = radians_of(60.0);  ///< of the viewer
    /// Flocks farther from the viewer stand still, and should not be shown. Metres, for a view of 60 degrees: who
    /// magnifies sees birds so much farther. [0, 100,000]
    double within_m = 600.0;

    std::uint32_t flying = 0;  ///< birds that the last tick moved

    /// Whether the viewer is near enough to see birds of it.
    [[nodiscard]] bool is_near(std::uint32_t flock) const;

    /// Scratch of the system: a flock's birds, in the registry's order.
    struct Seen {
        std::vector<Vec3> places, velocities, pulls;  ///< places relative to the home
        std::size_t next = 0;
    };
    std::vector<Seen> seen;
};

/// Where the birds of a flock are at first, and how they fly: in a ring, all the same way round.
struct BirdStart {
    ecs::LocalTransform at;
    Bird bird;
};
/// @param number  [0, flock.birds)
/// @param index   of the flock among Flocks::homes
[[nodiscard]] BirdStart start_of(const Flocks::Home& home, std::uint32_t number, std::uint32_t birds,
                                 std::uint32_t index);

/// What move_birds touches.
[[nodiscard]] ecs::Access bird_access();

/// One tick of 1/120 s of all flocks that are near. A flock of n birds takes time in n squared: 256 of them 0.1 ms.
void move_birds(ecs::SystemContext& context);

/// Adds move_birds to a schedule, as "birds".
void add_bird_system(ecs::Schedule& schedule);

}  // namespace ff::scenery
