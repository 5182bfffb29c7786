#pragma once
// A row of a tile compared with something, as bits: no branch and no search, a few vectors of the width that every
// machine has.

#include <hwy/highway.h>

#include <cstdint>

#include "engine/farfield/visibility_buffer.h"

namespace ff::farfield {

/// Pixels of a row of a tile, by bits.
using TileRow = std::uint32_t;
inline constexpr TileRow kWholeTileRow = (1u << kTileSize) - 1u;

/// Bits of a row from a function that gives the mask of the four lanes of `d` from the i-th pixel on.
template <class D, class FourOf>
inline TileRow tile_row_of(D d, FourOf&& four_of) {
    static_assert(hwy::HWY_NAMESPACE::MaxLanes(D()) == 4);
    TileRow row = 0;
    for (int i = 0; i < kTileSize; i += 4) {
        std::uint8_t bits[8];
        hwy::HWY_NAMESPACE::StoreMaskBits(d, four_of(i), bits);
        row |= TileRow(bits[0]) << i;
    }
    return row;
}

/// Where a row of numbers is one number.
inline TileRow equal_in_row(const std::uint32_t* row, std::uint32_t number) {
    namespace hn = hwy::HWY_NAMESPACE;
    constexpr hn::FixedTag<std::uint32_t, 4> four;
    const auto wanted = hn::Set(four, number);
    return tile_row_of(four, [&](int i) { return hn::Eq(hn::LoadU(four, row + i), wanted); });
}

}  // namespace ff::farfield
