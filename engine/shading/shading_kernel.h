#pragma once

#include <cstdint>
#include <span>

#include "engine/shading/shade_frame.h"
#include "engine/shading/tile_records.h"

namespace ff::shading {

/// Shades tiles one after the other with the widest vectors that this machine has.
/// @return pixels shaded.
std::uint64_t shade_tile_batch(const ShadeFrame& frame, std::span<const farfield::TileRequest> tiles,
                               TileScratch& scratch);

}  // namespace ff::shading
