#pragma once

#include <cstdint>
#include <vector>

#include "engine/farfield/visibility_buffer.h"

namespace ff::test {

/// Every pixel of an image of this size, tile by tile.
inline std::vector<farfield::TileRequest> all_tiles(int width, int height) {
    std::vector<farfield::TileRequest> tiles;
    for (int y = 0; y < height; y += farfield::kTileSize)
        for (int x = 0; x < width; x += farfield::kTileSize) {
            farfield::TileRequest tile{.x = std::uint16_t(x), .y = std::uint16_t(y)};
            for (std::uint16_t& row : tile.rows) row = 0xFFFF;
            tiles.push_back(tile);
        }
    return tiles;
}

}  // namespace ff::test
