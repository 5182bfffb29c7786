#pragma once
// The regular grids of the grid caster (P0 4.2): one per mesh over its triangles, and one over all instances. One grid
// over a world of 30 km would be too coarse where a tree stands, or far too large.

#include <cstdint>
#include <vector>

#include "engine/math/bounds.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield::grid {

/// Cells with the items that may reach into them. Item lists follow each other in cell order, x fastest, then y, z.
struct Grid {
    Vec3 low{0.0f};                         ///< corner of cell (0, 0, 0)
    Vec3 cells_per_m{0.0f};                 ///< per axis
    int count[3] = {0, 0, 0};               ///< cells per axis; 0: an empty grid
    std::vector<std::uint32_t> first_item;  ///< [cells + 1]
    std::vector<std::uint32_t> items;
    /// Cells to the nearest cell that has items, in the largest coordinate; 0: has some. A walk may step over that
    /// many less one (proximity clouds: Cohen, Sheffer, "Proximity clouds", The Visual Computer 1994).
    std::vector<std::uint8_t> clearance;

    [[nodiscard]] std::size_t cell(int x, int y, int z) const {
        return (std::size_t(z) * std::size_t(count[1]) + std::size_t(y)) * std::size_t(count[0]) + std::size_t(x);
    }
    [[nodiscard]] std::uint64_t memory_bytes() const {
        return 4 * (first_item.size() + items.size()) + clearance.size();
    }
};

/// Grid over the triangles of a mesh, mesh space. Triangles enter the cells that their box and their plane meet.
/// @param cells_per_item  cells for each triangle, > 0; at most 512 an axis
[[nodiscard]] Grid make_mesh_grid(const scene::StaticScene& scene, const scene::Mesh& mesh, double cells_per_item);

/// Grid over the instances' boxes, relative to scene.origin.
/// @param cells_per_item  cells for each instance, > 0; at most 512 an axis
[[nodiscard]] Grid make_instance_grid(const scene::StaticScene& scene, double cells_per_item);

}  // namespace ff::farfield::grid
