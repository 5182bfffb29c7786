#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {

std::uint64_t count_pixels(std::span<const TileRequest> tiles, int width, int height) {
    std::uint64_t count = 0;
    for (const TileRequest& tile : tiles)
        for (int row = 0; row < kTileSize; ++row)
            count += std::uint64_t(std::popcount(row_inside(tile, row, width, height)));
    return count;
}

}  // namespace ff::farfield
