#pragma once

#include <vector>

#include "engine/physics/physics_world.h"

namespace ff::beacons {

/// A way on foot from one place to near another: A* (Hart, Nilsson and Raphael 1968) over a grid of steps that a walker
/// can take, each tried by queries when it is first looked at.
/// @param reach_m  so near is near enough
/// @return points on the ground, the goal's side last; empty: there is none within `most_places` looked at
[[nodiscard]] std::vector<WorldPos> find_way(const physics::PhysicsWorld& physics, const WorldPos& from,
                                             const WorldPos& to, double reach_m, std::size_t most_places = 200'000);

}  // namespace ff::beacons
