#pragma once
// One bit per pixel, kept in tiles of 16 x 16: which pixels are covered, which are sky, which are still to be answered.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/farfield/visibility_buffer.h"

namespace ff::farfield {

/// Bit i of rows[j] is pixel (x + i, y + j) of the tile at (x, y), as in TileRequest.
struct alignas(32) TileMask {
    std::uint16_t rows[kTileSize]{};

    [[nodiscard]] int count() const {
        int bits = 0;
        for (const std::uint16_t row : rows) bits += std::popcount(row);
        return bits;
    }
};
static_assert(sizeof(TileMask) == 32);

/// The tiles of an image, row-major from the top left. Bits of pixels beyond width or height are always 0.
struct PixelMask {
    int width = 0, height = 0;     ///< pixels
    int tiles_x = 0, tiles_y = 0;  ///< tiles that cover them
    std::vector<TileMask> tiles;   ///< [tiles_x * tiles_y]

    /// Sets the size and clears every bit. Allocates only when the image grows.
    void reset(int new_width, int new_height) {
        width = new_width;
        height = new_height;
        tiles_x = (width + kTileSize - 1) / kTileSize;
        tiles_y = (height + kTileSize - 1) / kTileSize;
        tiles.assign(std::size_t(tiles_x) * std::size_t(tiles_y), TileMask{});
    }
    [[nodiscard]] bool test(int x, int y) const {
        const TileMask& tile = tiles[std::size_t(y / kTileSize) * std::size_t(tiles_x) + std::size_t(x / kTileSize)];
        return ((tile.rows[y % kTileSize] >> (x % kTileSize)) & 1) != 0;
    }
    void set(int x, int y) {
        TileMask& tile = tiles[std::size_t(y / kTileSize) * std::size_t(tiles_x) + std::size_t(x / kTileSize)];
        tile.rows[y % kTileSize] = std::uint16_t(tile.rows[y % kTileSize] | (1u << (x % kTileSize)));
    }
    [[nodiscard]] TileMask& tile_of(const TileRequest& request) {
        return tiles[std::size_t(request.y / kTileSize) * std::size_t(tiles_x) + std::size_t(request.x / kTileSize)];
    }
    [[nodiscard]] std::uint64_t count() const {
        std::uint64_t bits = 0;
        for (const TileMask& tile : tiles) bits += std::uint64_t(tile.count());
        return bits;
    }
};

}  // namespace ff::farfield
