#pragma once
// From tile masks to packets of near pixels. A caster is fast when its lanes are full and its rays go the same way, so
// blocks that are mostly wanted go as they are, and what sparse blocks leave over is collected along a Z-order walk
// until it fills a packet: a packet then still covers a small part of the image.

#include <bit>
#include <cstdint>
#include <span>

#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"

namespace ff::farfield {

/// Pixels of one packet; lanes from `count` on repeat the last pixel so that they may be computed without harm.
template <int kWidth>
struct PixelPacket {
    alignas(64) std::uint32_t x[kWidth];
    alignas(64) std::uint32_t y[kWidth];
    int count = 0;
};

/// Bits of a request that lie inside an image of width x height pixels.
[[nodiscard]] inline std::uint32_t row_inside(const TileRequest& tile, int row, int width, int height) {
    if (int(tile.y) + row >= height) return 0;
    const int columns = width - int(tile.x);
    if (columns <= 0) return 0;
    const std::uint32_t inside = columns >= kTileSize ? 0xFFFFu : (1u << columns) - 1u;
    return tile.rows[row] & inside;
}

/// Number of pixels that the tiles ask for inside the image.
[[nodiscard]] std::uint64_t count_pixels(std::span<const TileRequest> tiles, int width, int height);

/// Number of pixels that the tiles ask for and that see sky.
[[nodiscard]] std::uint64_t count_sky(std::span<const TileRequest> tiles, const VisibilityBuffer& visibility);

/// Answers the pixels of a tile with sky.
void write_sky(const PinholeView& view, const TileRequest& tile, VisibilityBuffer& out);

/// Splits tiles into full blocks and packets of leftovers.
/// Blocks are 4 pixels wide and kWidth / 4 high, and are visited in Z-order within a tile.
/// @param tiles   neighbours should follow each other: leftovers run on from one tile to the next
/// @param block   called as block(x, y, mask): bit i of the mask is the pixel (x + i % 4, y + i / 4); at least
///                kMinFill of the kWidth bits are set
/// @param packet  called as packet(const PixelPacket<kWidth>&), 1 <= count <= kWidth
/// @tparam kPacketBlocks  blocks after which leftovers go as they are, a power of two: a caster that suffers more from
///                wide packets than from empty lanes keeps them small; 0: never before the end
template <int kWidth, int kPacketBlocks = 0, class BlockFunction, class PacketFunction>
void regroup(std::span<const TileRequest> tiles, int width, int height, BlockFunction&& block,
             PacketFunction&& packet) {
    constexpr int kBlockRows = kWidth / 4;
    constexpr int kBlocksPerTile = 4 * (kTileSize / kBlockRows);
    // A packet with idle lanes costs as much as a full one; regrouping costs coherence. Half full is where they break
    // even for tiles of one surface, three quarters where surfaces are small.
    constexpr int kMinFill = kWidth * 5 / 8;
    PixelPacket<kWidth> rest;
    const auto flush = [&] {
        if (rest.count == 0) return;
        for (int lane = rest.count; lane < kWidth; ++lane) {
            rest.x[lane] = rest.x[rest.count - 1];
            rest.y[lane] = rest.y[rest.count - 1];
        }
        packet(rest);
        rest.count = 0;
    };
    for (const TileRequest& tile : tiles) {
        std::uint32_t rows[kTileSize];
        std::uint32_t any = 0;
        for (int row = 0; row < kTileSize; ++row) any |= rows[row] = row_inside(tile, row, width, height);
        if (any == 0) continue;
        for (int b = 0; b < kBlocksPerTile; ++b) {
            if constexpr (kPacketBlocks != 0) {
                if (b % kPacketBlocks == 0) flush();
            }
            // De-interleave the block's number: even bits are columns, odd bits rows, what is left over rows.
            const int column = (b & 1) | ((b >> 1) & 2);
            const int block_row = ((b >> 1) & 1) | ((b >> 2) & ~1);
            const int first_row = block_row * kBlockRows;
            std::uint32_t mask = 0;
            for (int row = 0; row < kBlockRows; ++row)
                mask |= ((rows[first_row + row] >> (4 * column)) & 15u) << (4 * row);
            if (mask == 0) continue;
            const std::uint32_t x = tile.x + 4u * std::uint32_t(column), y = tile.y + std::uint32_t(first_row);
            if (std::popcount(mask) >= kMinFill) {
                block(x, y, mask);
                continue;
            }
            for (std::uint32_t left = mask; left != 0; left &= left - 1) {
                const auto bit = std::uint32_t(std::countr_zero(left));
                rest.x[rest.count] = x + (bit & 3u);
                rest.y[rest.count] = y + (bit >> 2);
                if (++rest.count == kWidth) flush();
            }
        }
    }
    flush();
}

}  // namespace ff::farfield
