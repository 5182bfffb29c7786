#pragma once
// Part of the reprojection: what is known of a scene that is being edited. Interface: reproject.h.

#include <span>

#include "engine/farfield/reproject.h"
#include "engine/math/bounds.h"

namespace ff::farfield::reprojection {

/// Leaves out the points of the last frame that lie in a box in which something has changed: what they name may be
/// something else by now.
void drop_points(std::span<const DBox3> changed, const PinholeView& last_view, const VisibilityBuffer& last,
                 ReprojectedPoints& points);

/// Pixels of a tile whose rays meet a box before or where they reach what `out` holds.
/// @param answered  which pixels of `out` count
[[nodiscard]] TileMask pixels_behind(std::span<const DBox3> changed, const PinholeView& view,
                                     const TileRequest& answered, const VisibilityBuffer& out);

}  // namespace ff::farfield::reprojection
