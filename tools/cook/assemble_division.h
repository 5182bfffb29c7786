#pragma once
// Which triangles and instances go into which cell of the ground.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "tools/cook/assemble.h"
#include "tools/cook/assemble_cells.h"

namespace ff::cook {

/// Placements by what becomes of them; each list in the source's order.
struct SortedPlacements {
    std::vector<std::uint32_t> merged, instanced, dynamic;
    std::vector<std::uint64_t> first_triangle;  // of each merged one in the numbering of all merged triangles; [n + 1]
};

/// Ids by cells: of triangles in the numbering of all merged triangles, then of instances in that of `instanced`.
struct CellDivision {
    std::vector<std::uint32_t> ids;
    std::vector<CellRange> cells;  ///< ranges of `ids`
};

/// Errors: a placement that a world cannot have, see assemble().
[[nodiscard]] Status check_placements(const WorldSource& source);

/// Which placements keep a mesh of their own: dynamic ones, and instances unless merging is cheaper. [placements]
[[nodiscard]] std::vector<bool> find_whole_placements(const WorldSource& source, const AssembleSettings& settings);

/// @param whole  find_whole_placements
/// Errors: more triangles than a world can have.
[[nodiscard]] Result<SortedPlacements> sort_placements(const WorldSource& source, const std::vector<bool>& whole);

/// Every merged triangle goes where its centroid lies, every instance where its mesh's middle lies.
/// @param geometry  hash_geometry; not read where the cache is off
/// Errors: something lies too far away, see assemble().
[[nodiscard]] Result<CellDivision> divide_into_cells(const WorldSource& source, const SortedPlacements& sorted,
                                                     const AssembleSettings& settings, const std::string& geometry,
                                                     CookCache& cache);

}  // namespace ff::cook
