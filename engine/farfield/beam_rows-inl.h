// Triangles that are set up, into the pixels that they win: the nearest stays, on a tie the smaller (instance,
// triangle); see-through texels win nothing. Compiled once per SIMD target; include after <hwy/highway.h>.
#if defined(FF_BEAM_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_BEAM_ROWS_INL_H_
#undef FF_BEAM_ROWS_INL_H_
#else
#define FF_BEAM_ROWS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>

#include "engine/farfield/beam_alpha-inl.h"
#include "engine/farfield/beam_setup-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

// A triangle of a leaf that is set up, as a register of pixels wants it.
struct Drawn {
    VF a[3], b[3], c[3];
    VF gx, gy, g0, low, high;
    bool is_thin;
    HWY_INLINE Drawn(const LeafScratch& s, int i)
        : gx(hn::Set(f, s.gx[i])),
          gy(hn::Set(f, s.gy[i])),
          g0(hn::Set(f, s.g0[i])),
          low(hn::Set(f, s.low[i])),
          high(hn::Set(f, s.high[i])),
          is_thin(s.thin[i] != 0.0f) {
        for (int k = 0; k < 3; ++k) {
            a[k] = hn::Set(f, s.a[k][i]);
            b[k] = hn::Set(f, s.b[k][i]);
            c[k] = hn::Set(f, s.c[k][i]);
        }
    }
};

// Pixels at which a see-through triangle would win if it is there. They wait until they fill a register: a row of
// foliage has four or five, and to ask for their texels costs the same for one and for all lanes.
struct AlphaCandidates {
    const Drawn& drawn;
    AlphaDraw& alpha;
    const LeafScratch& s;
    int i;
    Tile& tile;
    int count = 0;
    bool has_won = false;
    alignas(64) float x[2 * kLanes], y[2 * kLanes];

    HWY_INLINE AlphaCandidates(const Drawn& of, AlphaDraw& draw, const LeafScratch& leaf, int triangle, Tile& into)
        : drawn(of), alpha(draw), s(leaf), i(triangle), tile(into) {}

    HWY_INLINE void add(MF win, VF at_x, VF at_y) {
        hn::StoreU(hn::Compress(at_x, win), f, x + count);
        hn::StoreU(hn::Compress(at_y, win), f, y + count);
        count += int(hn::CountTrue(f, win));
        if (count < kLanes) return;
        settle(kLanes);
        count -= kLanes;
        hn::Store(hn::Load(f, x + kLanes), f, x);
        hn::Store(hn::Load(f, y + kLanes), f, y);
    }

    // The first few win where the triangle is opaque.
    HWY_NOINLINE void settle(int few) {
        const Drawn& d = drawn;
        const VF at_x = hn::Load(f, x), at_y = hn::Load(f, y);
        VF e[3];
        for (int k = 0; k < 3; ++k) e[k] = hn::MulAdd(d.b[k], at_y, hn::MulAdd(d.a[k], at_x, d.c[k]));
        const VF plane = hn::MulAdd(d.gy, at_y, hn::MulAdd(d.gx, at_x, d.g0));
        const VF inverse_depth = hn::Min(hn::Max(plane, d.low), d.high);
        const MF first = hn::FirstN(f, std::size_t(few));
        std::uint32_t won = bits_of(opaque_lanes(first, alpha, s, i, at_x, at_y, e, inverse_depth));
        if (won == 0) return;
        has_won = true;
        const VF half = hn::Set(f, kHalf);
        const VF row = hn::Add(at_y, half), column = hn::Add(at_x, half);
        alignas(64) std::int32_t pixels[kLanes];
        alignas(64) float depths[kLanes];
        hn::Store(integer_of(hn::MulAdd(row, hn::Set(f, float(kRowStride)), column)), si, pixels);
        hn::Store(inverse_depth, f, depths);
        for (; won != 0; won &= won - 1) {
            const int lane = std::countr_zero(won), pixel = pixels[lane];
            tile.best[pixel] = depths[lane];
            tile.instance[pixel] = alpha.instance;
            tile.triangle[pixel] = alpha.triangle;
        }
    }
};

// A register's pixels of a triangle on any rows: what depends on the columns alone is done once.
// @tparam kBehind  only what lies beyond Tile::behind_* counts
template <bool kBehind>
struct ColumnTerms {
    const Drawn& d;
    const LeafScratch& s;
    int i;
    const Tile& tile;
    VF x, e0, e1, e2, plane, too_near;
    HWY_INLINE ColumnTerms(const Drawn& drawn, const LeafScratch& leaf, int triangle, const Tile& into, VF at_x)
        : d(drawn),
          s(leaf),
          i(triangle),
          tile(into),
          x(at_x),
          e0(hn::MulAdd(d.a[0], x, d.c[0])),
          e1(hn::MulAdd(d.a[1], x, d.c[1])),
          e2(hn::MulAdd(d.a[2], x, d.c[2])),
          plane(hn::MulAdd(d.gx, x, d.g0)),
          too_near(hn::MulAdd(hn::Set(f, tile.behind_x), x, hn::Set(f, tile.behind_c))) {}

    // Not-a-number (a sliver's plane) becomes `low`: x86's max returns its second operand then.
    HWY_INLINE VF inverse_depth(VF y) const { return hn::Min(hn::Max(hn::MulAdd(d.gy, y, plane), d.low), d.high); }
    // Those that the triangle covers, no farther away than `best`.
    HWY_INLINE MF covered(VF y, VF inverse_depth, VF best) const {
        const VF inside = min3(hn::MulAdd(d.b[0], y, e0), hn::MulAdd(d.b[1], y, e1), hn::MulAdd(d.b[2], y, e2));
        MF win = hn::And(hn::Ge(inside, hn::Zero(f)), hn::Ge(inverse_depth, best));
        if constexpr (kBehind)
            win = hn::And(win, hn::Lt(inverse_depth, hn::MulAdd(hn::Set(f, tile.behind_y), y, too_near)));
        if (HWY_UNLIKELY(d.is_thin)) {
            const VF low_x = hn::Set(f, float(s.x0[i]) - kHalf), high_x = hn::Set(f, float(s.x1[i]) - kHalf);
            win = hn::And(win, hn::And(hn::Ge(x, low_x), hn::Le(x, high_x)));
        }
        return win;
    }
};

// Draws a register's columns from `column` on, rows y0..y1; true if a pixel was won.
// @param see_through  nullptr: it is not; else pixels are left to them, and none is won
template <bool kAlpha, bool kBehind>
HWY_INLINE bool draw_columns(const Drawn& d, int column, int y0, int y1, std::uint32_t instance, std::uint32_t triangle,
                             Tile& tile, AlphaCandidates* see_through, const LeafScratch& s, int i) {
    const ColumnTerms<kBehind> terms(d, s, i, tile, hn::Iota(f, float(column) - kHalf));
    MF any = hn::MaskFromVec(hn::Zero(f));
    VF y = hn::Set(f, float(y0) - kHalf);
    for (int row = y0; row <= y1; ++row, y = hn::Add(y, hn::Set(f, 1.0f))) {
        const VF inverse_depth = terms.inverse_depth(y);
        const int at = row * kRowStride + column;
        const VF best = hn::LoadU(f, tile.best + at);
        MF win = terms.covered(y, inverse_depth, best);
        // Half of the registers win something: to write back what was there is cheaper than to guess.
        if constexpr (kAlpha) {
            if (hn::AllFalse(f, win)) continue;
        }
        const auto own_instance = hn::Set(ui, instance), own_triangle = hn::Set(ui, triangle);
        const auto old_instance = hn::LoadU(ui, tile.instance + at), old_triangle = hn::LoadU(ui, tile.triangle + at);
        const MF tie = hn::And(win, hn::Eq(inverse_depth, best));
        if (HWY_UNLIKELY(!hn::AllFalse(f, tie))) {
            const auto smaller =
                hn::Or(hn::Lt(own_instance, old_instance),
                       hn::And(hn::Eq(own_instance, old_instance), hn::Lt(own_triangle, old_triangle)));
            win = hn::AndNot(hn::AndNot(hn::RebindMask(f, smaller), tie), win);
        }
        if constexpr (kAlpha) {
            see_through->add(win, terms.x, y);
            continue;
        }
        hn::StoreU(hn::IfThenElse(win, inverse_depth, best), f, tile.best + at);
        const auto win_u = hn::RebindMask(ui, win);
        hn::StoreU(hn::IfThenElse(win_u, own_instance, old_instance), ui, tile.instance + at);
        hn::StoreU(hn::IfThenElse(win_u, own_triangle, old_triangle), ui, tile.triangle + at);
        any = hn::Or(any, win);
    }
    return !hn::AllFalse(f, any);
}

// Lanes of a register as a block of pixels, row by row.
template <int kColumns>
struct BlockLanes {
    static constexpr int kRows = kLanes / kColumns;
    static_assert(kRows * kColumns == kLanes && kRows >= 2);
    using Row = hn::CappedTag<float, kColumns>;
    alignas(64) float x[kLanes], y[kLanes];
};
template <int kColumns>
constexpr BlockLanes<kColumns> block_lanes() {
    BlockLanes<kColumns> lanes{};
    for (int lane = 0; lane < kLanes; ++lane) {
        lanes.x[lane] = float(lane % kColumns);
        lanes.y[lane] = float(lane / kColumns);
    }
    return lanes;
}

template <int kColumns>
HWY_INLINE VF load_block(const float* first) {
    constexpr typename BlockLanes<kColumns>::Row row;
    const auto at = [&](int r) HWY_ATTR { return hn::LoadU(row, first + r * kRowStride); };
    if constexpr (BlockLanes<kColumns>::kRows == 2) {
        return hn::Combine(f, at(1), at(0));
    } else {
        const hn::Half<F> half;
        return hn::Combine(f, hn::Combine(half, at(3), at(2)), hn::Combine(half, at(1), at(0)));
    }
}

// Of lanes that are as near as what a block's pixels show, by bits, those whose triangle has the greater name.
template <int kColumns>
HWY_NOINLINE std::uint32_t lost_ties(std::uint32_t tie, int at, std::uint32_t instance, std::uint32_t triangle,
                                     const Tile& tile) {
    std::uint32_t lost = 0;
    for (; tie != 0; tie &= tie - 1) {
        const int lane = std::countr_zero(tie), pixel = at + lane / kColumns * kRowStride + lane % kColumns;
        const std::uint32_t other = tile.instance[pixel];
        const bool is_smaller = instance < other || (instance == other && triangle < tile.triangle[pixel]);
        if (!is_smaller) lost |= tie & (~tie + 1);
    }
    return lost;
}

// As draw_columns(), to the same bits, for a triangle no wider than kColumns: several rows to a register, as most
// triangles are but a few pixels wide.
template <bool kAlpha, bool kBehind, int kColumns>
HWY_INLINE bool draw_narrow(const Drawn& d, int column, int y0, int y1, std::uint32_t instance, std::uint32_t triangle,
                            Tile& tile, AlphaCandidates* see_through, const LeafScratch& s, int i) {
    using Lanes = BlockLanes<kColumns>;
    constexpr typename Lanes::Row row_d;
    constexpr hn::RebindToUnsigned<typename Lanes::Row> row_u;
    static constexpr Lanes kBlock = block_lanes<kColumns>();
    const ColumnTerms<kBehind> terms(d, s, i, tile, hn::Add(hn::Load(f, kBlock.x), hn::Set(f, float(column) - kHalf)));
    bool any = false;
    for (int row = y0; row <= y1; row += Lanes::kRows) {
        const VF y = hn::Add(hn::Load(f, kBlock.y), hn::Set(f, float(row) - kHalf));
        const VF inverse_depth = terms.inverse_depth(y);
        const int at = row * kRowStride + column;
        const VF best = load_block<kColumns>(tile.best + at);
        const MF win = terms.covered(y, inverse_depth, best);
        // Rows beyond the last are not the tile's.
        const int lanes = (y1 - row + 1) * kColumns;
        const std::uint32_t rows_left = lanes >= kLanes ? ~0u : (1u << lanes) - 1u;
        std::uint32_t bits = bits_of(win) & rows_left;
        if (bits == 0) continue;
        const std::uint32_t tie = bits & bits_of(hn::Eq(inverse_depth, best));
        if (HWY_UNLIKELY(tie != 0)) bits &= ~lost_ties<kColumns>(tie, at, instance, triangle, tile);
        if (bits == 0) continue;
        if constexpr (kAlpha) {
            see_through->add(mask_of(bits), terms.x, y);
            continue;
        }
        any = true;
        alignas(64) float depths[kLanes];
        hn::Store(inverse_depth, f, depths);
        for (int r = 0; r < Lanes::kRows; ++r, bits >>= kColumns) {
            const std::uint8_t of_row[8] = {std::uint8_t(bits & ((1u << kColumns) - 1u))};
            if (of_row[0] == 0) continue;
            const auto won = hn::LoadMaskBits(row_d, of_row);
            const auto won_u = hn::RebindMask(row_u, won);
            const int to = at + r * kRowStride;
            hn::BlendedStore(hn::Load(row_d, depths + r * kColumns), won, row_d, tile.best + to);
            hn::BlendedStore(hn::Set(row_u, instance), won_u, row_u, tile.instance + to);
            hn::BlendedStore(hn::Set(row_u, triangle), won_u, row_u, tile.triangle + to);
        }
    }
    return any;
}

// First and last pixel centres of the cells' columns and rows.
struct CellCorners {
    alignas(64) float x[2][16], y[2][16];
};
constexpr CellCorners cell_corners() {
    CellCorners corners{};
    for (int cell = 0; cell < kCells * kCells; ++cell) {
        for (int side = 0; side < 2; ++side) {
            corners.x[side][cell] = float(cell % kCells * 8 + side * 7) - kHalf;
            corners.y[side][cell] = float(cell / kCells * 8 + side * 7) - kHalf;
        }
    }
    return corners;
}
constexpr CellCorners kCellCorners = cell_corners();

// Cells that triangle i may win pixels of, as bits: the corner where an edge function or 1/depth is greatest is asked,
// with the very operations of the pixels.
HWY_INLINE std::uint32_t cells_to_draw(const Drawn& d, const LeafScratch& s, int i, const Tile& tile) {
    std::uint32_t cells = 0;
    for (int first = 0; first < kCells * kCells; first += kLanes) {
        const auto most = [&](float slope_x, float slope_y, VF a, VF b, VF c) {
            const VF x = hn::Load(f, kCellCorners.x[slope_x >= 0.0f] + first);
            const VF y = hn::Load(f, kCellCorners.y[slope_y >= 0.0f] + first);
            return hn::MulAdd(b, y, hn::MulAdd(a, x, c));
        };
        const VF inside =
            min3(most(s.a[0][i], s.b[0][i], d.a[0], d.b[0], d.c[0]), most(s.a[1][i], s.b[1][i], d.a[1], d.b[1], d.c[1]),
                 most(s.a[2][i], s.b[2][i], d.a[2], d.b[2], d.c[2]));
        const VF nearest = hn::Min(hn::Max(most(s.gx[i], s.gy[i], d.gx, d.gy, d.g0), d.low), d.high);
        const VF best = hn::Load(f, &tile.cell_best[0][0] + first);
        cells |= bits_of(hn::And(hn::Ge(inside, hn::Zero(f)), hn::Ge(nearest, best))) << first;
    }
    return cells;
}

// Draws triangle i of the leaf into the pixels that it wins; true if any.
template <bool kAlpha, bool kBehind>
HWY_INLINE bool draw_pixels(const Drawn& d, const LeafScratch& s, int i, std::uint32_t instance, std::uint32_t triangle,
                            Tile& tile, AlphaCandidates* see_through) {
    const int x0 = s.x0[i], x1 = s.x1[i], y0 = s.y0[i], y1 = s.y1[i];
    const auto columns = [&](int column, int first_row, int last_row) {
        return draw_columns<kAlpha, kBehind>(d, column, first_row, last_row, instance, triangle, tile, see_through, s,
                                             i);
    };
    if (kLanes >= 8 && x1 - x0 < 4)
        return draw_narrow<kAlpha, kBehind, std::min(4, kLanes / 2)>(d, x0, y0, y1, instance, triangle, tile,
                                                                     see_through, s, i);
    if (kLanes >= 16 && x1 - x0 < 8)
        return draw_narrow<kAlpha, kBehind, std::min(8, kLanes / 2)>(d, x0, y0, y1, instance, triangle, tile,
                                                                     see_through, s, i);
    bool has_won = false;
    if (x1 - x0 < 8) {
        for (int column = x0; column <= x1; column += kLanes) has_won |= columns(column, y0, y1);
        return has_won;
    }
    // Much of a wide triangle's bounds lies outside or behind.
    const std::uint32_t cells = cells_to_draw(d, s, i, tile);
    constexpr int kCellsAtOnce = std::max(1, kLanes / 8);
    for (int row = y0; row <= y1; row = row / 8 * 8 + 8) {
        const std::uint32_t of_row = cells >> row / 8 * kCells;
        for (int column = x0 / 8 * 8; column <= x1; column += kLanes) {
            if ((of_row >> column / 8 & ((1u << kCellsAtOnce) - 1u)) == 0) continue;
            has_won |= columns(column, row, std::min(y1, row / 8 * 8 + 7));
        }
    }
    return has_won;
}

// The same, and notes the cells that have changed.
// @param alpha  of a see-through triangle
template <bool kAlpha, bool kBehind = false>
HWY_INLINE void draw(const LeafScratch& s, int i, std::uint32_t instance, std::uint32_t triangle, Tile& tile,
                     AlphaDraw* alpha) {
    const Drawn d(s, i);
    bool has_won;
    if constexpr (kAlpha) {
        AlphaCandidates candidates(d, *alpha, s, i, tile);
        (void)draw_pixels<true, kBehind>(d, s, i, instance, triangle, tile, &candidates);
        if (candidates.count > 0) candidates.settle(candidates.count);
        has_won = candidates.has_won;
    } else {
        has_won = draw_pixels<false, kBehind>(d, s, i, instance, triangle, tile, nullptr);
    }
    if (has_won) tile.changed_cells |= cells_of(s.x0[i], s.x1[i], s.y0[i], s.y1[i]);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
