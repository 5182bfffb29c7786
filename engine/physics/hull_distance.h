#pragma once

#include <optional>

#include "engine/physics/geometry.h"

namespace ff::physics {

/// How a segment lies to a convex body, in that body's frame.
struct HullNearest {
    double distance = 0.0;  ///< negative: how far in, along `normal`
    DVec3 normal{0.0};      ///< unit, outward
    DVec3 on_segment{0.0};
    DVec3 on_hull{0.0};
};

/// Nothing beyond `reach`. Inside, the way out is that of the nearest face.
/// @param geometry  a box or a hull
[[nodiscard]] std::optional<HullNearest> nearest_on_hull(const Segment& segment, double reach,
                                                         const Geometry& geometry);

}  // namespace ff::physics
