#pragma once
// Part of the reprojection: what landed in and around a tile, and how many points vote for each hit. Interface:
// reproject.h.

#include "engine/farfield/known_primitives.h"
#include "engine/farfield/reproject.h"
#include "engine/farfield/reproject_splat.h"

namespace ff::farfield::reprojection {

/// What landed in a tile and the pixels around it: bit i of row j is pixel (x + i - 1, y + j - 1).
struct Landed {
    std::uint32_t filled[kTileSize + 2];
    std::uint32_t sky[kTileSize + 2];     ///< of these
    std::uint32_t abrupt[kTileSize + 2];  ///< nothing else
};

/// Reads the surroundings of the tile at (x, y), and adds the primitives that landed there to a set.
void read_tile(const AuxiliaryBand& band, int x, int y, Landed& landed, PrimitiveSet& primitives);

/// Pixels of a tile of which at least `least` of the 3 x 3 around have their bit set. `least` in [0, 9].
[[nodiscard]] TileMask count_around(const std::uint32_t (&bits)[kTileSize + 2], int least);

/// Of a tile's hits, those for which enough of the 3 x 3 points vote; Vote::surface or Vote::primitive.
/// @param all_solid  pixels around which nine points of instances landed
[[nodiscard]] TileMask count_votes(const AuxiliaryBand& band, const VisibilityBuffer& hits, const TileRequest& tile,
                                   const TileMask& all_solid, const ReprojectSettings& settings);

/// P3 5.3: writes at each pixel of a tile how far its ray need not look, as depth: up to the nearest of the nine points
/// that landed around it, and as much less as still counts as one surface.
/// @param shifted  pixels around which nine points landed that are worth it; all others get 0
void write_origins(const AuxiliaryBand& band, const TileRequest& tile, const TileMask& shifted, float surface_share,
                   VisibilityBuffer& out);

}  // namespace ff::farfield::reprojection
