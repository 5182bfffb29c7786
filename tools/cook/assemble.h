#pragma once
// From a world as plain arrays to the scene that casters and rasteriser read: cells, deduplicated vertices,
// hierarchies, shared textures.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/scene/world.h"
#include "tools/cook/coincident_surfaces.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

struct AssembleSettings {
    double largest_cell_m = 4096.0;  ///< side of the quadtree's roots; a power of two times smallest_cell_m
    double smallest_cell_m = 64.0;
    std::uint32_t cell_triangles = 16384;      ///< a larger cell is split while its side allows
    std::uint32_t merge_instances_below = 32;  ///< triangles of a mesh that is merged rather than instanced ...
    std::uint32_t merge_uses_up_to = 16;       ///< ... unless it is placed more often than this
    std::uint32_t height_grid_size = 1024;     ///< squares a side, a power of two
};

struct Assembly {
    scene::SceneData scene;  ///< finished
    scene::WorldInfo info;
    std::uint64_t dropped_triangles = 0;  ///< without area
    CoincidentReport coincident;
};

/// Builds the scene. Static geometry goes to the cell in which the triangle's centroid lies, float32 relative to the
/// cell's origin (whole metres), computed in double; a triangle larger than its cell stays whole, cells' bounds follow
/// their contents. Instances and dynamic objects keep a mesh of their own. Equal textures and materials become one,
/// unused ones are left out.
/// Errors: bad_input where a placement or a triangle lies further than kMaxWorldCoordinate from the origin, or where
/// the world has more than 32-bit ids can count.
/// Parallel inside; the result does not depend on the number of workers. The source's arrays are consumed.
[[nodiscard]] Result<Assembly> assemble(WorldSource source, const AssembleSettings& settings, CookContext& context);

}  // namespace ff::cook
