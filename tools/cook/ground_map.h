#pragma once
// Where one can walk: the floors of a part of a world, one or several above each other, how they join, and how far
// from the next obstacle each place is.
// Based on: Mononen, Recast Navigation, 2009 (solid spans per column, walkable tops, chamfer distances). Ours differs:
//   floors are kept per column without regions' contours; worlds of buildings without ground get a ground.

#include <array>
#include <cstdint>
#include <vector>

#include "tools/cook/ground_density.h"

namespace ff::cook {

/// A place of one cell to stand on.
struct GroundNode {
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

    float y = 0;            ///< of the floor, metres above GroundMap::base_y
    float ceiling = 0;      ///< lowest solid thing above, metres above base_y; +inf outdoors
    float clearance_m = 0;  ///< from the cell's middle to the next wall, drop or end of the ground; a lower bound
    bool is_open = false;   ///< nothing at all above, no leaves either
    std::uint32_t column = 0;
    std::uint32_t region = kNone;  ///< GroundMap::region_cells; none where narrow
    std::array<std::uint32_t, 4> neighbours{kNone, kNone, kNone, kNone};  ///< to -x, -z, +x, +z

    [[nodiscard]] bool is_outdoors() const { return ceiling > 1e30f; }
};

struct GroundMap {
    static constexpr double kHeadroom_m = 2.0;
    static constexpr double kRegionClearance_m = 1.2;  ///< regions join where there is so much room on all sides

    double low_x = 0, low_z = 0, base_y = 0;
    double cell_m = 0.5;
    int width = 0, depth = 0;               ///< columns along x and z
    bool is_made_up = false;                ///< the world has no ground: this one lies at the feet of its things
    std::vector<std::uint32_t> first_node;  ///< per column, and one more
    std::vector<float> top;                 ///< per column: the highest thing, metres above base_y; -inf: nothing
    std::vector<GroundNode> nodes;          ///< by columns, upwards in each
    std::vector<std::uint32_t> region_cells;

    [[nodiscard]] PointXZ middle_of(const GroundNode& node) const {
        return {low_x + (node.column % std::uint32_t(width) + 0.5) * cell_m,
                low_z + (node.column / std::uint32_t(width) + 0.5) * cell_m};
    }
    /// The floor nearest to a height there, at most `reach_m` above or below; kNone where there is none.
    [[nodiscard]] std::uint32_t node_at(double x, double z, double y, double reach_m) const;
    /// The highest thing within a square around a place, world metres; -inf where there is nothing.
    [[nodiscard]] double top_near(double x, double z, double half_side_m) const;
    /// Largest difference of the heights of joined neighbours: a step for fine cells, a slope for coarse ones.
    [[nodiscard]] double step_m() const { return cell_m > 0.5 ? 0.9 * cell_m : 0.45; }
};

/// The ground within 256 m (along x and z) of a place. Cells are 0.5 m, larger where the triangles would cover too
/// many. Takes about a second a million triangles; parallel; deterministic for any number of workers.
[[nodiscard]] GroundMap make_ground_map(const StaticTriangles& triangles, const DensityMap& density, PointXZ center);

}  // namespace ff::cook
