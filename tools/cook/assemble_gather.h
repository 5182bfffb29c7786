#pragma once
// The triangles of a cell, brought together from the placements that have some in it; and the sources let go of as soon
// as no cell needs them any more, so that a large world is never in memory twice.

#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/cook/assemble_division.h"
#include "tools/cook/assemble_mesh.h"
#include "tools/cook/free_memory.h"

namespace ff::cook {

/// What a cell is made of.
struct CellPlan {
    struct Run {  ///< consecutive ids of one placement
        std::uint32_t placement = 0;
        std::uint32_t first_triangle = 0;  ///< id of the placement's triangle 0
        std::size_t begin = 0, end = 0;    ///< of CellDivision::ids
    };
    DVec3 origin{0.0};  ///< whole metres near its middle
    std::vector<Run> runs;
};

class Gatherer {
  public:
    /// @param instanced_meshes  ids of meshes that are gathered whole, once each
    /// All arguments outlive the gatherer; it empties the source's meshes as they are used up.
    Gatherer(WorldSource& source, const SortedPlacements& sorted, const CellDivision& division,
             std::span<const std::uint16_t> material_ids, std::span<const std::uint32_t> instanced_meshes);

    [[nodiscard]] CellPlan plan(const CellRange& cell) const;
    /// Hash of what gather() reads for a cell; the meshes are hashed.
    [[nodiscard]] std::string inputs(const CellPlan& cell) const;
    [[nodiscard]] GatheredMesh gather(const CellPlan& cell) const;
    /// A mesh that keeps its own space: for instances and dynamic objects.
    [[nodiscard]] GatheredMesh gather_whole(std::uint32_t mesh) const;
    /// The cell, the mesh is done. Threads: any, each cell and mesh once.
    void release(const CellPlan& cell);
    void release_whole(std::uint32_t mesh) { use_up(mesh, 1); }

  private:
    void use_up(std::uint32_t mesh, std::uint64_t uses);
    void free_mesh(std::uint32_t mesh);

    WorldSource& source_;
    const SortedPlacements& sorted_;
    const CellDivision& division_;
    std::span<const std::uint16_t> material_ids_;
    std::vector<std::atomic<std::uint64_t>> uses_left_;  ///< per mesh: triangles to be merged, and 1 if needed whole
    FreedMemory freed_;
};

}  // namespace ff::cook
