// Regular resampling (P3 4.3): a rank-1 lattice. For a period of 9 it takes one block of every 3 x 3, as P3 Figure 5
// does, and no two of a frame are nearer than 3 blocks.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/farfield/reproject.h"

namespace ff::farfield {

TileMask resample_mask(const ReprojectSettings& settings, int tile_x, int tile_y, std::uint64_t frame_number) {
    TileMask mask;
    if (settings.resample_period <= 0) return mask;
    const int period = settings.resample_period, block = settings.resample_block_px;
    const int row_shift = int(std::lround(std::sqrt(double(period))));
    // Successive frames take places far apart: steps of about a third of the lattice that reach all of it.
    int stride = std::max(1, 2 * period / 5);
    while (std::gcd(stride, period) != 1) ++stride;
    const int due = int(frame_number % std::uint64_t(period)) * stride % period;
    if (block >= kTileSize) {
        const int tiles = block / kTileSize;
        const bool is_due = (tile_x / tiles + tile_y / tiles * row_shift) % period == due;
        std::fill(std::begin(mask.rows), std::end(mask.rows), std::uint16_t(is_due ? 0xFFFF : 0));
        return mask;
    }
    const int blocks = kTileSize / block;
    const std::uint32_t ones = (1u << block) - 1u;
    for (int by = 0; by < blocks; ++by) {
        const int row_place = (tile_y * blocks + by) * row_shift;
        std::uint32_t bits = 0;
        for (int bx = 0; bx < blocks; ++bx)
            if ((tile_x * blocks + bx + row_place) % period == due) bits |= ones << (bx * block);
        for (int row = by * block; row < (by + 1) * block; ++row) mask.rows[row] = std::uint16_t(bits);
    }
    return mask;
}

}  // namespace ff::farfield
