#pragma once

#include <string>
#include <vector>

#include "engine/math/types.h"
#include "engine/scene/walk.h"

namespace ff::beacons {

/// A way through the world: a walk of its pack, by distance.
struct Path {
    std::vector<WorldPos> points;  ///< at least two, apart from each other
    std::vector<double> at_m;      ///< distance of each point from the first
    bool closed = false;           ///< the last point is the first

    [[nodiscard]] double length_m() const { return at_m.back(); }
};

/// Empty where the walk stays in one place.
[[nodiscard]] Path make_path(const scene::Walk& walk);

struct PathPoint {
    WorldPos position{0.0};
    double yaw = 0.0;  ///< radians, the way it goes
};
/// Where something is that has gone so far; past the end it goes back, or round where the path is closed.
[[nodiscard]] PathPoint point_on(const Path& path, double distance_m);

}  // namespace ff::beacons
