#pragma once

#include "engine/shading/shade_frame.h"
#include "engine/shading/tile_records.h"

namespace ff::shading {

/// Lists the tile's triangles once each into scratch.names, and which of them every requested pixel sees into
/// scratch.offset (elsewhere: anything valid). Names outside the scene count as sky.
/// @param rows  bit i of rows[j]: pixel (x + i, y + j) is wanted; none outside the image
void collect_triangles(const ShadeFrame& frame, int x, int y, const std::uint16_t rows[farfield::kTileSize],
                       TileScratch& scratch);

}  // namespace ff::shading
