#include "tools/cook/ground_density.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "engine/core/jobs.h"
#include "tools/cook/ground_cells.h"

namespace ff::cook {
namespace {

constexpr int kMostCells = 512;  // a side
constexpr double kUsualCell_m = 4.0;
constexpr double kCoarsestCell_m = 16.0;  // a larger world is looked at again, closer
constexpr int kStripRows = 16;
constexpr double kDenseHalfSide_m = 150.0;

DensityMap map_of(const StaticTriangles& triangles, double low_x, double low_z, double extent_m) {
    DensityMap map{.low_x = low_x, .low_z = low_z};
    // A single object is seen in 64 cells a side, a town in cells of 4 m, a landscape in 512 cells a side.
    map.cell_m = std::max(extent_m / kMostCells, std::min(kUsualCell_m, extent_m / 64));
    map.width = map.depth = std::clamp(static_cast<int>(std::ceil(extent_m / map.cell_m)), 1, kMostCells);
    const std::size_t cells = std::size_t(map.width) * std::size_t(map.depth);
    map.low.assign(cells, std::numeric_limits<float>::infinity());
    map.high.assign(cells, -std::numeric_limits<float>::infinity());
    std::vector<std::uint32_t> counts(cells, 0);

    const int strips = (map.depth + kStripRows - 1) / kStripRows;
    const auto pieces =
        pieces_by_strip(triangles, low_x, low_x + map.width * map.cell_m, low_z, kStripRows * map.cell_m, strips);
    parallel_for(std::size_t(strips), [&](std::size_t strip) {
        const CellRect rect{0, int(strip) * kStripRows, map.width, std::min(map.depth, (int(strip) + 1) * kStripRows)};
        for (const std::uint32_t piece : pieces[strip])
            triangles.visit(triangles.pieces()[piece], [&](const WorldTriangle& triangle) {
                std::array<DVec3, 3> corners;
                DVec3 middle(0.0);
                for (std::size_t c = 0; c < 3; ++c) {
                    const DVec3& p = triangle.corners[c];
                    corners[c] = DVec3((p.x - low_x) / map.cell_m, p.y, (p.z - low_z) / map.cell_m);
                    middle += corners[c] / 3.0;
                }
                for_each_cell(corners, rect, [&](int x, int z, double low, double high) {
                    const std::size_t cell = std::size_t(z) * std::size_t(map.width) + std::size_t(x);
                    map.low[cell] = std::min(map.low[cell], static_cast<float>(low));
                    map.high[cell] = std::max(map.high[cell], static_cast<float>(high));
                });
                if (middle.x >= rect.x0 && middle.x < rect.x1 && middle.z >= rect.z0 && middle.z < rect.z1)
                    counts[std::size_t(middle.z) * std::size_t(map.width) + std::size_t(middle.x)] +=
                        triangle.is_level ? 1u : 8u;
            });
    });

    const std::size_t pitch = std::size_t(map.width) + 1;
    map.sums.assign(pitch * (std::size_t(map.depth) + 1), 0);
    for (std::size_t z = 0; z < std::size_t(map.depth); ++z)
        for (std::size_t x = 0; x < std::size_t(map.width); ++x)
            map.sums[(z + 1) * pitch + x + 1] = counts[z * std::size_t(map.width) + x] + map.sums[z * pitch + x + 1] +
                                                map.sums[(z + 1) * pitch + x] - map.sums[z * pitch + x];
    return map;
}

CellRect cells_near(const DensityMap& map, double x, double z, double half) {
    const auto cell = [&](double v, double low, int count) {
        return static_cast<int>(std::clamp(std::floor((v - low) / map.cell_m), -1.0, double(count)));
    };
    return {std::max(0, cell(x - half, map.low_x, map.width)), std::max(0, cell(z - half, map.low_z, map.depth)),
            std::min(map.width, cell(x + half, map.low_x, map.width) + 1),
            std::min(map.depth, cell(z + half, map.low_z, map.depth) + 1)};
}

}  // namespace

std::size_t DensityMap::index_at(double x, double z) const {
    const auto cell = [&](double v, double corner, int count) {
        return static_cast<std::size_t>(std::clamp((v - corner) / cell_m, 0.0, double(count - 1)));
    };
    return cell(z, low_z, depth) * std::size_t(width) + cell(x, low_x, width);
}

std::uint64_t DensityMap::triangles_near(double x, double z, double half_side_m) const {
    const CellRect r = cells_near(*this, x, z, half_side_m);
    if (r.x0 >= r.x1 || r.z0 >= r.z1) return 0;
    const auto sum = [&](int column, int row) { return sums[std::size_t(row) * (std::size_t(width) + 1) + column]; };
    return sum(r.x1, r.z1) + sum(r.x0, r.z0) - sum(r.x0, r.z1) - sum(r.x1, r.z0);
}

double DensityMap::top_near(double x, double z, double half_side_m) const {
    const CellRect r = cells_near(*this, x, z, half_side_m);
    double top = -std::numeric_limits<double>::infinity();
    for (int row = r.z0; row < r.z1; ++row)
        for (int column = r.x0; column < r.x1; ++column)
            top = std::max(top, double(high[std::size_t(row) * std::size_t(width) + std::size_t(column)]));
    return top;
}

DensityMap make_density_map(const StaticTriangles& triangles, std::optional<PointXZ> around) {
    const DBox3& bounds = triangles.bounds();
    if (bounds.is_empty()) return {};
    const DVec3 middle = bounds.center();
    double extent = std::max(bounds.extent().x, bounds.extent().z) * (1.0 + 1e-9) + 1e-6;
    if (around && extent > kMostCells * kCoarsestCell_m) {
        extent = kMostCells * kCoarsestCell_m;
        return map_of(triangles, around->x - extent / 2, around->z - extent / 2, extent);
    }
    PointXZ center{middle.x, middle.z};
    while (true) {
        DensityMap map = map_of(triangles, center.x - extent / 2, center.z - extent / 2, extent);
        if (map.cell_m <= kCoarsestCell_m) return map;
        center = densest_place(map);
        extent = std::max(extent / 32, kMostCells * kCoarsestCell_m);
    }
}

PointXZ densest_place(const DensityMap& map) {
    std::tuple<std::uint64_t, std::uint64_t, double> best{0, 0, -std::numeric_limits<double>::infinity()};
    PointXZ place{map.low_x, map.low_z};
    for (int z = 0; z < map.depth; ++z)
        for (int x = 0; x < map.width; ++x) {
            const PointXZ here{map.low_x + (x + 0.5) * map.cell_m, map.low_z + (z + 0.5) * map.cell_m};
            const std::tuple score(map.triangles_near(here.x, here.z, kDenseHalfSide_m),
                                   map.triangles_near(here.x, here.z, kDenseHalfSide_m / 4),
                                   -std::hypot(x - 0.5 * map.width, z - 0.5 * map.depth));
            if (score > best) best = score, place = here;
        }
    return place;
}

std::vector<std::vector<std::uint32_t>> pieces_by_strip(const StaticTriangles& triangles, double low_x, double high_x,
                                                        double low_z, double strip_m, int count) {
    std::vector<std::vector<std::uint32_t>> strips(static_cast<std::size_t>(count));
    for (std::uint32_t i = 0; i < triangles.pieces().size(); ++i) {
        const DBox3& box = triangles.pieces()[i].bounds;
        if (box.high.x < low_x || box.low.x > high_x) continue;
        // A hair wider: boxes are rounded otherwise than triangles.
        const double first = std::floor((box.low.z - low_z) / strip_m - 1e-3);
        const double last = std::floor((box.high.z - low_z) / strip_m + 1e-3);
        if (last < 0.0 || first >= count) continue;
        for (auto s = std::size_t(std::max(first, 0.0)); s <= std::size_t(std::min(last, count - 1.0)); ++s)
            strips[s].push_back(i);
    }
    return strips;
}

}  // namespace ff::cook
