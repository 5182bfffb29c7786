#pragma once
// Surfaces of a source that lie exactly in one plane and over each other (doubled triangles, road tiles over a ground,
// a poster in the plane of its wall) show through each other in patches, differently in every renderer. Here they are
// told apart, once for all renderers.

#include <cstdint>
#include <vector>

#include "tools/cook/world_source.h"

namespace ff::cook {

struct CoincidentReport {
    std::uint64_t dropped_triangles = 0;  ///< covered exactly by another one; in a mesh with instances each counts once
    std::uint64_t separated_triangles = 0;  ///< moved out of a common plane; likewise
    std::uint64_t dropped_placements = 0;   ///< by drop_repeated_placements
    std::uint64_t moved_placements = 0;     ///< instances moved as a whole
    bool complete = true;                   ///< false: more than is looked for (see find_coincident_pairs)
};

/// Drops static placements that repeat an earlier one: the same mesh without blending at the same place. Returns how
/// many.
std::uint64_t drop_repeated_placements(WorldSource& world);

/// Drops triangles that are covered by others exactly: the earlier of two opaque ones that face the same way (the later
/// is what a depth test of less-or-equal shows), and one of two that look the same from both sides (foliage made of
/// triangles back to back: faces are drawn from both sides here). Moves the rest apart (order_coincident), and corners
/// of neighbours that stood at the same points with them, so that no crack opens.
/// A mesh that stays whole is changed once for all its placements; one that is merged in some places and not in others
/// is copied first. Placements that say so (Placement::stands_clear) are left as they are.
/// Looks at instances as a whole only while these are kMostInstancedTriangles together; beyond, only inside meshes.
/// @param stays_whole  for each placement: it keeps a mesh of its own (else its triangles go into cells)
/// Deterministic for any number of workers. Placements are finite and invertible.
[[nodiscard]] CoincidentReport resolve_coincident_surfaces(WorldSource& world, const std::vector<bool>& stays_whole);

inline constexpr std::uint64_t kMostInstancedTriangles = 4'000'000;

}  // namespace ff::cook
