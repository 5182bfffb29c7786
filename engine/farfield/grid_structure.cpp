#include "engine/farfield/grid_structure.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::farfield::grid {
namespace {

constexpr int kMaxCellsPerAxis = 512;

struct CellRange {
    int low[3], high[3];  ///< inclusive
};

CellRange cells_of(const Grid& grid, const Vec3& low, const Vec3& high) {
    // Wider by a thousandth of a cell: positions inside a cell are computed with rounding when rays are cast.
    CellRange range;
    for (int axis = 0; axis < 3; ++axis) {
        const int last = grid.count[axis] - 1;
        const float a = (low[axis] - grid.low[axis]) * grid.cells_per_m[axis] - 1e-3f;
        const float b = (high[axis] - grid.low[axis]) * grid.cells_per_m[axis] + 1e-3f;
        range.low[axis] = std::clamp(int(std::floor(a)), 0, last);
        range.high[axis] = std::clamp(int(std::floor(b)), 0, last);
    }
    return range;
}

/// Chooses cells that are about cubes.
void lay_out(Grid& grid, const Box3& bounds, double cells) {
    Vec3 extent = bounds.extent();
    const float largest = std::max({extent.x, extent.y, extent.z, 1e-3f});
    extent = glm::max(extent, Vec3(1e-3f * largest));
    // A little air, so that nothing lies on the outermost faces.
    const Vec3 margin = extent * 1e-4f;
    grid.low = bounds.low - margin;
    extent += 2.0f * margin;
    const double volume = double(extent.x) * double(extent.y) * double(extent.z);
    const double side = std::cbrt(volume / cells);
    for (int axis = 0; axis < 3; ++axis) {
        grid.count[axis] = std::clamp(int(std::lround(double(extent[axis]) / side)), 1, kMaxCellsPerAxis);
        grid.cells_per_m[axis] = float(grid.count[axis]) / extent[axis];
    }
}

/// Two passes over the items, counting and then entering them.
template <class VisitCells>
void fill(Grid& grid, std::size_t items, VisitCells&& visit_cells) {
    const std::size_t cells = std::size_t(grid.count[0]) * std::size_t(grid.count[1]) * std::size_t(grid.count[2]);
    grid.first_item.assign(cells + 1, 0);
    for (std::uint32_t i = 0; i < items; ++i) visit_cells(i, [&](std::size_t cell) { ++grid.first_item[cell + 1]; });
    for (std::size_t c = 0; c < cells; ++c) grid.first_item[c + 1] += grid.first_item[c];
    grid.items.resize(grid.first_item[cells]);
    std::vector<std::uint32_t> next(grid.first_item.begin(), grid.first_item.end() - 1);
    for (std::uint32_t i = 0; i < items; ++i) visit_cells(i, [&](std::size_t cell) { grid.items[next[cell]++] = i; });
}

template <class Visit>
void visit_range(const CellRange& range, Visit&& visit) {
    for (int z = range.low[2]; z <= range.high[2]; ++z)
        for (int y = range.low[1]; y <= range.high[1]; ++y)
            for (int x = range.low[0]; x <= range.high[0]; ++x) visit(x, y, z);
}

/// Distance in the largest coordinate, by two sweeps over the half of the neighbours that were visited before.
void measure_clearance(Grid& grid) {
    const int nx = grid.count[0], ny = grid.count[1], nz = grid.count[2];
    const std::size_t cells = grid.first_item.size() - 1;
    grid.clearance.resize(cells);
    for (std::size_t c = 0; c < cells; ++c) grid.clearance[c] = grid.first_item[c] == grid.first_item[c + 1] ? 255 : 0;
    const auto relax = [&](int x, int y, int z, int sign) {
        std::uint8_t& own = grid.clearance[grid.cell(x, y, z)];
        if (own == 0) return;
        int least = own;
        for (int dz = -1; dz <= 0; ++dz)
            for (int dy = -1; dy <= (dz < 0 ? 1 : 0); ++dy)
                for (int dx = -1; dx <= (dz < 0 || dy < 0 ? 1 : -1); ++dx) {
                    const int i = x + sign * dx, j = y + sign * dy, k = z + sign * dz;
                    if (i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || k >= nz) continue;
                    least = std::min(least, grid.clearance[grid.cell(i, j, k)] + 1);
                }
        own = std::uint8_t(least);
    };
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) relax(x, y, z, 1);
    for (int z = nz - 1; z >= 0; --z)
        for (int y = ny - 1; y >= 0; --y)
            for (int x = nx - 1; x >= 0; --x) relax(x, y, z, -1);
}

}  // namespace

Grid make_mesh_grid(const scene::StaticScene& scene, const scene::Mesh& mesh, double cells_per_item) {
    Grid grid;
    if (mesh.triangle_count == 0) return grid;
    const auto corner = [&](std::uint32_t triangle, std::size_t k) -> const Vec3& {
        return scene
            .positions[mesh.first_vertex + scene.indices[3 * (std::size_t(mesh.first_triangle) + triangle) + k]];
    };
    Box3 bounds;
    for (std::uint32_t t = 0; t < mesh.triangle_count; ++t)
        for (std::size_t k = 0; k < 3; ++k) bounds.add(corner(t, k));
    lay_out(grid, bounds, cells_per_item * mesh.triangle_count);
    const Vec3 half = 0.501f / grid.cells_per_m;
    fill(grid, mesh.triangle_count, [&](std::uint32_t t, auto&& visit) {
        const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
        const CellRange range = cells_of(grid, glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)));
        const Vec3 normal = glm::cross(b - a, c - a);
        const float reach = glm::dot(glm::abs(normal), half);
        visit_range(range, [&](int x, int y, int z) {
            const Vec3 center = grid.low + (Vec3(x, y, z) + 0.5f) / grid.cells_per_m;
            if (std::fabs(glm::dot(normal, center - a)) <= reach * 1.001f) visit(grid.cell(x, y, z));
        });
    });
    measure_clearance(grid);
    return grid;
}

Grid make_instance_grid(const scene::StaticScene& scene, double cells_per_item) {
    Grid grid;
    Box3 bounds;
    const auto box_of = [&](const scene::Instance& instance) {
        return Box3{Vec3(instance.bounds.low - scene.origin), Vec3(instance.bounds.high - scene.origin)};
    };
    for (const scene::Instance& instance : scene.instances)
        if (!instance.bounds.is_empty()) bounds.add(box_of(instance));
    if (bounds.is_empty()) return grid;
    lay_out(grid, bounds, cells_per_item * double(scene.instances.size()));
    fill(grid, scene.instances.size(), [&](std::uint32_t i, auto&& visit) {
        if (scene.instances[i].bounds.is_empty()) return;
        const Box3 box = box_of(scene.instances[i]);
        visit_range(cells_of(grid, box.low, box.high), [&](int x, int y, int z) { visit(grid.cell(x, y, z)); });
    });
    measure_clearance(grid);
    return grid;
}

}  // namespace ff::farfield::grid
