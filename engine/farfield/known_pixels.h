#pragma once
// Ideal ray shooting of a whole view (P3 7.3, IRSA): each pixel's primitive is known, and its one intersection is
// computed. The bound of everything that first has to find the primitive.

#include <span>

#include "engine/farfield/known_primitives.h"
#include "engine/farfield/ray_caster.h"

namespace ff::farfield {

/// Intersects the pixels that the tiles ask for with the primitives that `visibility` names there, and writes what it
/// finds: the nearest of the tile's own primitives. A pixel that none of them covers, as happens within rounding of an
/// edge, and sky stay as they were.
/// @return rays: pixels that were confirmed; triangles: primitives set up
/// Threads: parallel over tiles; the result does not depend on the number of workers.
CastCost cast_known_pixels(const scene::StaticScene& scene, const PinholeView& view, std::span<const TileRequest> tiles,
                           VisibilityBuffer& visibility);

}  // namespace ff::farfield
