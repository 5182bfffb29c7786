// The opacity buffer from a depth buffer that was read back or that a software rasteriser left.
#include <algorithm>
#include <limits>

#include "engine/farfield/opacity_buffer.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/opacity_depth.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void mark_drawn(const float* depth, std::ptrdiff_t row_step, EmptyDepth empty, PixelMask& covered) {
    const hn::CappedTag<float, 16> d;
    // Drawn: low <= depth <= high. NaN is not.
    const float low =
        empty == EmptyDepth::zero ? std::numeric_limits<float>::denorm_min() : -std::numeric_limits<float>::max();
    const auto lowest = hn::Set(d, low), highest = hn::Set(d, std::numeric_limits<float>::max());
    for (int y = 0; y < covered.height; ++y) {
        const float* row = depth + std::ptrdiff_t(y) * row_step;
        TileMask* tiles = covered.tiles.data() + std::size_t(y / kTileSize) * std::size_t(covered.tiles_x);
        for (int tile = 0; tile < covered.tiles_x; ++tile, row += kTileSize) {
            const int columns = std::min(kTileSize, covered.width - tile * kTileSize);
            std::uint32_t bits = 0;
            if (columns == kTileSize) {
                for (std::size_t i = 0; i < kTileSize; i += hn::Lanes(d)) {
                    const auto value = hn::LoadU(d, row + i);
                    std::uint8_t bytes[8] = {};
                    hn::StoreMaskBits(d, hn::And(hn::Ge(value, lowest), hn::Le(value, highest)), bytes);
                    bits |= (std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8) << i;
                }
            } else {
                for (int i = 0; i < columns; ++i)
                    bits |= std::uint32_t(row[i] >= low && row[i] <= std::numeric_limits<float>::max()) << i;
            }
            tiles[tile].rows[y % kTileSize] = std::uint16_t(bits);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
HWY_EXPORT(mark_drawn);
void opacity_from_depth(const float* depth, std::ptrdiff_t row_step, int width, int height, EmptyDepth empty,
                        PixelMask& covered) {
    covered.reset(width, height);
    HWY_DYNAMIC_DISPATCH(mark_drawn)(depth, row_step, empty, covered);
}
}  // namespace ff::farfield
#endif
