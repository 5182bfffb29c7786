#pragma once

#include <span>
#include <vector>

#include "engine/farfield/ray_caster.h"

namespace ff::farfield {

/// Casts what a reprojection leaves: blocks that are due, and single pixels strewn over other tiles. A tile caster
/// takes the squares of which much is asked; the walk that it makes for few pixels of a square costs more than a packet
/// of neighbours from several tiles does.
/// @param left  row by row of tiles
/// @param few   answers the tiles of which little is asked
/// @param much  answers the others; may be the same
/// @param scratch_few, scratch_much  overwritten
/// @param shift_origin  `out` holds how far rays need not look (RayCaster::cast_tiles_beyond)
CastCost cast_left_over(RayCaster& few, RayCaster& much, const PinholeView& view, std::span<const TileRequest> left,
                        std::vector<TileRequest>& scratch_few, std::vector<TileRequest>& scratch_much,
                        bool shift_origin, VisibilityBuffer& out);

}  // namespace ff::farfield
