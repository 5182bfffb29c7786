#pragma once
// Where a world has its triangles, seen from above and coarsely.

#include <cstdint>
#include <optional>
#include <vector>

#include "tools/cook/ground_triangles.h"

namespace ff::cook {

struct PointXZ {
    double x = 0, z = 0;
};

/// A grid over the world, or over the part of about 8 km around the densest place of a larger one.
struct DensityMap {
    double low_x = 0, low_z = 0, cell_m = 1;
    int width = 0, depth = 0;         ///< cells along x and z; 0 for an empty world
    std::vector<float> low, high;     ///< of all triangles in a cell, metres; +inf, -inf where there are none
    std::vector<std::uint64_t> sums;  ///< summed area table of weighted triangle counts, (width + 1) x (depth + 1)

    [[nodiscard]] std::size_t index_at(double x, double z) const;  ///< of the cell; clamped to the border
    /// Triangles whose middles lie in cells that meet the square around a place. Level ones count 1, others 8: a plain,
    /// however finely cut, is no place to look at.
    [[nodiscard]] std::uint64_t triangles_near(double x, double z, double half_side_m) const;
    /// The highest thing in the cells that meet the square; -inf where there is nothing.
    [[nodiscard]] double top_near(double x, double z, double half_side_m) const;
};

/// @param around  the place that the part of a larger world is centred on; default: its densest
/// Deterministic for any number of workers.
[[nodiscard]] DensityMap make_density_map(const StaticTriangles& triangles,
                                          std::optional<PointXZ> around = std::nullopt);

/// The middle of the cell with the most triangles within 150 m, nearest to the map's middle among equals.
[[nodiscard]] PointXZ densest_place(const DensityMap& map);

/// The pieces that touch each of `count` strips of a grid, strip i being [low_z + i * strip_m, + strip_m).
[[nodiscard]] std::vector<std::vector<std::uint32_t>> pieces_by_strip(const StaticTriangles& triangles, double low_x,
                                                                      double high_x, double low_z, double strip_m,
                                                                      int count);

}  // namespace ff::cook
