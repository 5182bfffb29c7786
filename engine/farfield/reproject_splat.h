#pragma once
// Part of the reprojection: from targets to the auxiliary image. Interface: reproject.h.

#include "engine/farfield/reproject.h"

namespace ff::farfield::reprojection {

/// Rows of the auxiliary image plane, for one row of tiles: what landed where.
struct AuxiliaryBand {
    static constexpr int kRows = kTileSize + 2;
    /// Names from here on are of no instance.
    static constexpr std::uint32_t kAbrupt = 0xFFFFFFFDu;  ///< only points that came too fast
    static constexpr std::uint32_t kEmpty = kUnresolved;   ///< nothing landed here
    static_assert(kAbrupt < kEmpty && kEmpty < kSkyInstance);

    int stride = 0;
    int first_row = 0;                       ///< row of the image that its first one is; -1 for the topmost band
    ZeroPageVector<std::uint32_t> instance;  ///< or kSkyInstance, kEmpty, kAbrupt
    ZeroPageVector<std::uint32_t> triangle;  ///< of an instance
    ZeroPageVector<float> depth;             ///< of an instance's point: from the new eye, along its view axis

    void resize(const AuxiliaryLayout& layout);
    /// @param x, y  of the image
    [[nodiscard]] std::size_t index(int x, int y) const {
        return std::size_t(y - first_row) * std::size_t(stride) + std::size_t(x + AuxiliaryLayout::kBorder);
    }
};

/// Lets the points land that belong around a row of tiles: of those in one pixel the nearest stays, of equally near
/// ones the first in the old image's order.
void fill_band(const VisibilityBuffer& last, const ReprojectedPoints& points, int tile_y, AuxiliaryBand& band);

}  // namespace ff::farfield::reprojection
