#include "engine/farfield/tile_regroup.h"

#include <limits>

namespace ff::farfield {

std::uint64_t count_pixels(std::span<const TileRequest> tiles, int width, int height) {
    std::uint64_t count = 0;
    for (const TileRequest& tile : tiles)
        for (int row = 0; row < kTileSize; ++row)
            count += std::uint64_t(std::popcount(row_inside(tile, row, width, height)));
    return count;
}

std::uint64_t count_sky(std::span<const TileRequest> tiles, const VisibilityBuffer& visibility) {
    std::uint64_t count = 0;
    for (const TileRequest& tile : tiles)
        for (int row = 0; row < kTileSize; ++row) {
            if (tile.rows[row] == 0) continue;
            const std::uint32_t* instance = &visibility.instance[visibility.index(tile.x, tile.y + row)];
            unsigned sky = 0;
            for (unsigned i = 0; i < kTileSize; ++i) sky |= unsigned(instance[i] == kSkyInstance) << i;
            count += std::uint64_t(std::popcount(sky & tile.rows[row]));
        }
    return count;
}

void write_sky(const PinholeView& view, const TileRequest& tile, VisibilityBuffer& out) {
    for (int row = 0; row < kTileSize; ++row)
        for (std::uint32_t left = row_inside(tile, row, view.width, view.height); left != 0; left &= left - 1) {
            const std::size_t at = out.index(int(tile.x) + std::countr_zero(left), int(tile.y) + row);
            out.instance[at] = kSkyInstance;
            out.triangle[at] = 0;
            out.depth[at] = std::numeric_limits<float>::infinity();
        }
}

}  // namespace ff::farfield
