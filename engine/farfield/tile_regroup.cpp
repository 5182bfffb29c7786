#include "engine/farfield/tile_regroup.h"

#include <atomic>
#include <limits>

#include "engine/core/jobs.h"
#include "engine/farfield/tile_row.h"

namespace ff::farfield {

std::uint64_t count_pixels(std::span<const TileRequest> tiles, int width, int height) {
    std::uint64_t count = 0;
    for (const TileRequest& tile : tiles)
        for (int row = 0; row < kTileSize; ++row)
            count += std::uint64_t(std::popcount(row_inside(tile, row, width, height)));
    return count;
}

std::uint64_t count_sky(std::span<const TileRequest> tiles, const VisibilityBuffer& visibility) {
    constexpr std::size_t kTilesPerTask = 128;
    std::atomic<std::uint64_t> total{0};
    parallel_ranges(tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        std::uint64_t count = 0;
        for (const TileRequest& tile : tiles.subspan(begin, end - begin))
            for (int row = 0; row < kTileSize; ++row) {
                if (tile.rows[row] == 0) continue;
                const std::uint32_t* const instance = &visibility.instance[visibility.index(tile.x, tile.y + row)];
                count += std::uint64_t(std::popcount(equal_in_row(instance, kSkyInstance) & tile.rows[row]));
            }
        total.fetch_add(count, std::memory_order_relaxed);
    });
    return total;
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
