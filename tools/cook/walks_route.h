#pragma once
// Ways through the free ground: where to stand, and a route that turns a corner.

#include <optional>

#include "tools/cook/ground_map.h"

namespace ff::cook {

/// How far one walks straight ahead from a place with room on both sides, metres, at most 150.
/// @param bearing_deg  0 north (-z), 90 east (+x)
[[nodiscard]] double free_way_m(const GroundMap& map, std::uint32_t node, double bearing_deg);

struct FreeWays {
    double longest_deg = 0, longest_m = 0;
    double across_m = 0;  ///< the longest one at 60 to 120 degrees to it
};
[[nodiscard]] FreeWays free_ways(const GroundMap& map, std::uint32_t node);

/// The best place to stand: in the densest part, outdoors rather than indoors, free within 3 m where there is such a
/// place, with a large area within reach and ways to go. kNone where there is no ground worth the name.
[[nodiscard]] std::uint32_t find_spawn_node(const GroundMap& map, const DensityMap& density);

/// The roomy node nearest to a place, of a region worth the name; kNone where none is within 60 m.
[[nodiscard]] std::uint32_t find_node_near(const GroundMap& map, const DVec3& place);

/// A way on the ground: points 0.1 m apart, at the height of the floor.
struct WalkRoute {
    static constexpr double kSpacing_m = 0.1;
    std::vector<DVec3> points;
    double length_m() const { return points.empty() ? 0.0 : kSpacing_m * double(points.size() - 1); }
    /// Clamped to the ends.
    [[nodiscard]] DVec3 at(double s_m) const;
};

/// A smooth route of up to about 120 m through a place, at least 0.8 m from walls and drops: it comes along one free
/// way and leaves by another, if possible around a corner.
[[nodiscard]] WalkRoute plan_route(const GroundMap& map, std::uint32_t through);

/// Where a stretch of the route should begin so that it has a corner in it, near the middle of the route.
/// @param length_m  of the stretch that holds the corner
/// @param needed_m  that should still lie ahead
[[nodiscard]] double find_corner_start(const WalkRoute& route, double length_m, double needed_m);

}  // namespace ff::cook
