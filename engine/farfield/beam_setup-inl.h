// Triangles into edge functions and a plane of 1/depth over a tile, a register of them at a time.
//
// Based on: Olano, Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", HWWS 1997 (edge functions that
// need no clipping; here only for edges near or behind the eye plane, where projected ones fail; the others are
// projected first, because small distant triangles lose their shape in homogeneous cross products).
//
// No cracks: an edge function depends on its two vertices alone, changes its sign exactly with their order, and is
// widened by its own rounding error. So whatever lies in the closed triangles of tile-space vertices is found; what
// lies within that error of an edge is found twice, and depth decides.
//
// Compiled once per SIMD target; include after <hwy/highway.h>.
#if defined(FF_BEAM_SETUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_BEAM_SETUP_INL_H_
#undef FF_BEAM_SETUP_INL_H_
#else
#define FF_BEAM_SETUP_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "engine/farfield/beam_tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

struct alignas(64) LeafScratch {
    float x[32], y[32], iw[32];    // projected
    float hx[32], hy[32], hw[32];  // homogeneous; filled only where a vertex cannot be projected
    float a[3][16], b[3][16], c[3][16];
    float widening[3][16];         // what of c is not the edge's own
    float gx[16], gy[16], g0[16];  // 1/depth as a plane over the tile
    float low[16], high[16];       // its range over the triangle
    float weight[3][16];           // edge function to (unnormalised) barycentric
    float thin[16];                // not 0: hardly wider than the rounding of its edges
    std::int32_t x0[16], x1[16], y0[16], y1[16];
};

// table[index], index < 32, of which the first `count` entries are meant.
HWY_INLINE VF lookup(const float* HWY_RESTRICT table, VI index, int count) {
    if constexpr (kLanes == 8) {
        const auto lane = hn::IndicesFromVec(f, hn::And(index, hn::Set(si, 7)));
        const VF t0 = hn::TableLookupLanes(hn::Load(f, table), lane);
        if (count <= 8) return t0;
        const VF t1 = hn::TableLookupLanes(hn::Load(f, table + 8), lane);
        // Index bits moved to the sign choose between the tables.
        const MF bit3 = hn::MaskFromVec(hn::BitCast(f, hn::BroadcastSignBit(hn::ShiftLeft<28>(index))));
        const VF low = hn::IfThenElse(bit3, t1, t0);
        if (count <= 16) return low;
        const VF t2 = hn::TableLookupLanes(hn::Load(f, table + 16), lane);
        const VF t3 = hn::TableLookupLanes(hn::Load(f, table + 24), lane);
        const MF bit4 = hn::MaskFromVec(hn::BitCast(f, hn::BroadcastSignBit(hn::ShiftLeft<27>(index))));
        return hn::IfThenElse(bit4, hn::IfThenElse(bit3, t3, t2), low);
    } else if constexpr (kLanes == 16) {
        const auto lane = hn::IndicesFromVec(f, hn::And(index, hn::Set(si, 15)));
        const VF low = hn::TableLookupLanes(hn::Load(f, table), lane);
        if (count <= 16) return low;
        const VF high = hn::TableLookupLanes(hn::Load(f, table + 16), lane);
        return hn::IfThenElse(hn::RebindMask(f, hn::Gt(index, hn::Set(si, 15))), high, low);
    } else {
        return hn::GatherIndex(f, table, index);
    }
}

// Stores a register of vertices from entry `at` on, projected; true in lanes that could be.
HWY_INLINE MF store_projected(VF hx, VF hy, VF hw, LeafScratch& s, int at) {
    const VF limit = hn::Set(f, kMaxProjected);
    const VF iw = hn::Div(hn::Set(f, 1.0f), hw);
    const VF px = hn::Mul(hx, iw), py = hn::Mul(hy, iw);
    hn::StoreU(px, f, s.x + at);
    hn::StoreU(py, f, s.y + at);
    hn::StoreU(iw, f, s.iw + at);
    return hn::And(hn::Gt(hw, hn::Set(f, kMinW)), hn::And(hn::Le(hn::Abs(px), limit), hn::Le(hn::Abs(py), limit)));
}

HWY_INLINE void store_homogeneous(VF hx, VF hy, VF hw, LeafScratch& s, int at) {
    hn::StoreU(hx, f, s.hx + at);
    hn::StoreU(hy, f, s.hy + at);
    hn::StoreU(hw, f, s.hw + at);
}

// Both; true in lanes that could be projected.
HWY_INLINE MF store_vertices(VF hx, VF hy, VF hw, LeafScratch& s, int at) {
    store_homogeneous(hx, hy, hw, s, at);
    return store_projected(hx, hy, hw, s, at);
}

// Fills the tile-space vertices; true when all of them could be projected.
HWY_INLINE bool transform_vertices(const BvhLeaf& leaf, const Linear (&xyw)[3], LeafScratch& s) {
    const auto for_each = [&](auto&& store) HWY_ATTR {
        for (int v = 0; v < leaf.vertex_count; v += kLanes) {
            const VF x = hn::Load(f, leaf.x + v), y = hn::Load(f, leaf.y + v), z = hn::Load(f, leaf.z + v);
            const auto apply = [&](const Linear& l) HWY_ATTR {
                return hn::MulAdd(hn::Set(f, l.x), x,
                                  hn::MulAdd(hn::Set(f, l.y), y, hn::MulAdd(hn::Set(f, l.z), z, hn::Set(f, l.c))));
            };
            store(apply(xyw[0]), apply(xyw[1]), apply(xyw[2]), v);
        }
    };
    MF projected = hn::MaskFromVec(hn::BitCast(f, hn::Set(si, -1)));
    for_each([&](VF hx, VF hy, VF hw, int v)
                 HWY_ATTR { projected = hn::And(projected, store_projected(hx, hy, hw, s, v)); });
    if (HWY_LIKELY(hn::AllTrue(f, projected))) return true;
    for_each([&](VF hx, VF hy, VF hw, int v) HWY_ATTR { store_homogeneous(hx, hy, hw, s, v); });
    return false;
}

struct Corner {
    VF x, y, iw;       // projected
    VF hx, hy, hw;     // homogeneous
    MF front, usable;  // in front of the eye plane; projected coordinates may be used
};

struct Edge {
    VF a, b, c;  // a X + b Y + c
    VF error;    // to be added to c
};

// The constant is that of the edge's middle, not the cross product of its vertices: where an edge is short, as most in
// the distance are, that would be the small difference of two large numbers.
HWY_INLINE Edge projected_edge(const Corner& p, const Corner& q) {
    const VF half = hn::Set(f, 0.5f);
    const VF x = hn::Mul(half, hn::Add(p.x, q.x)), y = hn::Mul(half, hn::Add(p.y, q.y));
    Edge e{hn::Sub(p.y, q.y), hn::Sub(q.x, p.x), hn::Zero(f), hn::Zero(f)};
    const VF b_y = hn::Mul(e.b, y);
    e.c = hn::NegMulSub(e.a, x, b_y);
    const VF reach = hn::Set(f, float(kBeamSize / 2));
    const VF terms =
        hn::MulAdd(hn::Abs(e.a), hn::Add(reach, hn::Abs(x)), hn::Mul(hn::Abs(e.b), hn::Add(reach, hn::Abs(y))));
    e.error = hn::Mul(terms, hn::Set(f, kEdgeError));
    return e;
}

HWY_INLINE Edge homogeneous_edge(const Corner& p, const Corner& q) {
    const VF a0 = hn::Mul(p.hy, q.hw), a1 = hn::Mul(p.hw, q.hy);
    const VF b0 = hn::Mul(p.hw, q.hx), b1 = hn::Mul(p.hx, q.hw);
    const VF c0 = hn::Mul(p.hx, q.hy), c1 = hn::Mul(p.hy, q.hx);
    Edge e{hn::Sub(a0, a1), hn::Sub(b0, b1), hn::Sub(c0, c1), hn::Zero(f)};
    const VF ab = hn::Add(hn::Add(hn::Abs(a0), hn::Abs(a1)), hn::Add(hn::Abs(b0), hn::Abs(b1)));
    const VF terms = hn::MulAdd(ab, hn::Set(f, float(kBeamSize / 2)), hn::Add(hn::Abs(c0), hn::Abs(c1)));
    e.error = hn::Mul(terms, hn::Set(f, kEdgeError));
    return e;
}

HWY_INLINE Edge choose(MF mask, const Edge& yes, const Edge& no) {
    return {hn::IfThenElse(mask, yes.a, no.a), hn::IfThenElse(mask, yes.b, no.b), hn::IfThenElse(mask, yes.c, no.c),
            hn::IfThenElse(mask, yes.error, no.error)};
}

HWY_INLINE VF min3(VF a, VF b, VF c) {
    return hn::Min(a, hn::Min(b, c));
}
HWY_INLINE VF max3(VF a, VF b, VF c) {
    return hn::Max(a, hn::Max(b, c));
}

// The farthest 1/depth that the tile still has where bounds in pixels lie, or in the cells that they touch; anything
// for empty bounds.
HWY_INLINE VF farthest_under(VF x0, VF x1, VF y0, VF y1, const Tile& tile) {
    const auto cell = [](VF pixel) { return hn::ShiftRight<3>(integer_of(pixel)); };
    const VI columns = range_of_cells(cell(x0), cell(x1)), rows = range_of_cells(cell(y0), cell(y1));
    const VI range = hn::And(hn::Or(columns, hn::ShiftLeft<4>(rows)), hn::Set(si, 255));
    // Many triangles are a pixel large: that is asked itself.
    const MF is_pixel = hn::And(hn::Eq(x0, x1), hn::Eq(y0, y1));
    const VI pixel = integer_of(hn::MulAdd(y0, hn::Set(f, float(kRowStride)), x0));
    const VI at = hn::IfThenElse(hn::RebindMask(si, is_pixel), pixel, hn::Add(range, hn::Set(si, kLeast)));
    return hn::GatherIndex(f, tile.best, at);
}

// Sets up kLanes triangles from `first` on; returns those that may win a pixel, as bits.
// @tparam kByDepth    those behind what the tile has are dropped.
// @tparam kProjected  every vertex of the leaf can be projected.
// @tparam kDirect     the leaf's vertices lie as registers need them.
// @tparam kWidened    edge functions are stored widened by their rounding error; else as they are: those of an edge
//                     that two triangles share are then exactly opposite, so that a pixel can be given to one of the
//                     two.
template <bool kByDepth, bool kProjected, bool kDirect, bool kWidened = true>
HWY_NOINLINE std::uint32_t set_up(const BvhLeaf& leaf, int first, const Tile& tile, LeafScratch& s) {
    const int count = leaf.vertex_count;
    VI index[3];
    Corner p[3];
    const auto corner_of = [&](const float* table, int k) {
        if constexpr (kDirect)
            return hn::Load(f, table + k * BvhLeaf::kMaxDirect + first);
        else
            return lookup(table, index[k], count);
    };
    for (int k = 0; k < 3; ++k) {
        if constexpr (!kDirect) {
            const hn::Rebind<std::uint8_t, I> bytes;
            index[k] = hn::PromoteTo(si, hn::LoadU(bytes, leaf.corner[k] + first));
        }
        p[k].x = corner_of(s.x, k);
        p[k].y = corner_of(s.y, k);
        p[k].iw = corner_of(s.iw, k);
    }
    const MF valid = hn::RebindMask(f, hn::Lt(hn::Iota(si, first), hn::Set(si, leaf.triangle_count)));

    // Bounds in pixels; where a vertex lies behind the eye, all pixels.
    const VF outwards = hn::Set(f, kHalf + kBoundsMargin), inwards = hn::Set(f, kHalf - kBoundsMargin);
    VF x0 = hn::Ceil(hn::Add(min3(p[0].x, p[1].x, p[2].x), inwards));
    VF x1 = hn::Floor(hn::Add(max3(p[0].x, p[1].x, p[2].x), outwards));
    VF y0 = hn::Ceil(hn::Add(min3(p[0].y, p[1].y, p[2].y), inwards));
    VF y1 = hn::Floor(hn::Add(max3(p[0].y, p[1].y, p[2].y), outwards));
    VF low = min3(p[0].iw, p[1].iw, p[2].iw), high = max3(p[0].iw, p[1].iw, p[2].iw);
    MF all_usable = valid, all_front = valid;
    if constexpr (!kProjected) {
        const VF limit = hn::Set(f, kMaxProjected);
        MF any_front = hn::MaskFromVec(hn::Zero(f));
        low = hn::Set(f, kNearestInverse);
        for (int k = 0; k < 3; ++k) {
            p[k].hx = corner_of(s.hx, k);
            p[k].hy = corner_of(s.hy, k);
            p[k].hw = corner_of(s.hw, k);
            p[k].front = hn::Gt(p[k].hw, hn::Set(f, kMinW));
            p[k].usable = hn::And(p[k].front, hn::And(hn::Le(hn::Abs(p[k].x), limit), hn::Le(hn::Abs(p[k].y), limit)));
            all_usable = hn::And(all_usable, p[k].usable);
            all_front = hn::And(all_front, p[k].front);
            any_front = hn::Or(any_front, hn::Gt(p[k].hw, hn::Zero(f)));
            low = hn::IfThenElse(p[k].front, hn::Min(low, p[k].iw), low);
        }
        const VF everywhere = hn::Set(f, float(kBeamSize - 1));
        x0 = hn::IfThenElse(all_front, x0, hn::Zero(f));
        y0 = hn::IfThenElse(all_front, y0, hn::Zero(f));
        x1 = hn::IfThenElse(all_front, x1, everywhere);
        y1 = hn::IfThenElse(all_front, y1, everywhere);
        high = hn::IfThenElse(all_front, high, hn::Set(f, kNearestInverse));
        if (hn::AllFalse(f, hn::And(valid, any_front))) return 0;
    }
    x0 = hn::Max(x0, hn::Set(f, tile.first_column));
    x1 = hn::Min(x1, hn::Set(f, tile.last_column));
    y0 = hn::Max(y0, hn::Set(f, tile.first_row));
    y1 = hn::Min(y1, hn::Set(f, tile.last_row));
    MF alive = hn::And(valid, hn::And(hn::Le(x0, x1), hn::Le(y0, y1)));
    if (hn::AllFalse(f, alive)) return 0;
    if constexpr (kByDepth) alive = hn::And(alive, hn::Ge(high, farthest_under(x0, x1, y0, y1, tile)));
    if (hn::AllFalse(f, alive)) return 0;

    // Edge k lies opposite of corner k.
    Edge e[3];
    VF area, scale[3];
    const VF abx = hn::Sub(p[1].x, p[0].x), aby = hn::Sub(p[1].y, p[0].y);
    const VF acx = hn::Sub(p[2].x, p[0].x), acy = hn::Sub(p[2].y, p[0].y);
    area = hn::Sub(hn::Mul(abx, acy), hn::Mul(aby, acx));
    for (int k = 0; k < 3; ++k) {
        const Corner &q = p[(k + 1) % 3], &r = p[(k + 2) % 3];
        e[k] = projected_edge(q, r);
        scale[k] = p[k].iw;
        if constexpr (!kProjected) {
            const MF both = hn::And(q.usable, r.usable);
            e[k] = choose(both, e[k], homogeneous_edge(q, r));
            scale[k] =
                hn::IfThenElse(all_usable, scale[k], hn::IfThenElse(both, hn::Mul(q.hw, r.hw), hn::Set(f, 1.0f)));
        }
    }
    if constexpr (!kProjected) {
        // Twice the area in homogeneous coordinates. Where rounding may have made all of it, the triangle is seen
        // edge-on or is a sliver: everything on its line, behind the eye, too, would pass for inside.
        VF det = hn::Zero(f), terms = hn::Zero(f);
        for (int k = 0; k < 3; ++k) {
            const Corner &q = p[(k + 1) % 3], &r = p[(k + 2) % 3];
            const VF u = hn::Mul(q.hy, r.hw), v = hn::Mul(q.hw, r.hy);
            det = hn::MulAdd(p[k].hx, hn::Sub(u, v), det);
            terms = hn::MulAdd(hn::Abs(p[k].hx), hn::Add(hn::Abs(u), hn::Abs(v)), terms);
        }
        det = hn::IfThenElseZero(hn::Gt(hn::Abs(det), hn::Mul(terms, hn::Set(f, kEdgeError))), det);
        area = hn::IfThenElse(all_usable, area, det);
    }
    alive = hn::And(alive, hn::Ne(area, hn::Zero(f)));

    // Turn the triangle so that inside is positive; drop it where an edge leaves all its pixels outside. The corner of
    // the bounds is tested with the very operations of the rows, which are monotonic: nothing is lost.
    const VF sign = hn::And(area, hn::Set(f, -0.0f));
    const VF half = hn::Set(f, kHalf);
    const VF left = hn::Sub(x0, half), right = hn::Sub(x1, half), upper = hn::Sub(y0, half), lower = hn::Sub(y1, half);
    VF plain_c[3];
    for (int k = 0; k < 3; ++k) {
        e[k].a = hn::Xor(e[k].a, sign);
        e[k].b = hn::Xor(e[k].b, sign);
        plain_c[k] = hn::Xor(e[k].c, sign);
        e[k].c = hn::Add(plain_c[k], e[k].error);
        const VF best_x = hn::IfThenElse(hn::Ge(e[k].a, hn::Zero(f)), right, left);
        const VF best_y = hn::IfThenElse(hn::Ge(e[k].b, hn::Zero(f)), lower, upper);
        const VF most = hn::MulAdd(e[k].b, best_y, hn::MulAdd(e[k].a, best_x, e[k].c));
        alive = hn::And(alive, hn::Ge(most, hn::Zero(f)));
    }
    if (hn::AllFalse(f, alive)) return 0;

    // 1/depth is linear over the image.
    const VF inverse_area = hn::Div(hn::Set(f, 1.0f), area);
    const VF ab = hn::Sub(p[1].iw, p[0].iw), ac = hn::Sub(p[2].iw, p[0].iw);
    VF gx = hn::Mul(hn::Sub(hn::Mul(ab, acy), hn::Mul(ac, aby)), inverse_area);
    VF gy = hn::Mul(hn::Sub(hn::Mul(ac, abx), hn::Mul(ab, acx)), inverse_area);
    VF g0 = hn::NegMulAdd(gx, p[0].x, hn::NegMulAdd(gy, p[0].y, p[0].iw));
    if constexpr (!kProjected) {
        const VF inverse = hn::Abs(inverse_area);
        const auto blend = [&](VF u, VF v, VF w) {
            return hn::Mul(inverse, hn::MulAdd(u, scale[0], hn::MulAdd(v, scale[1], hn::Mul(w, scale[2]))));
        };
        gx = hn::IfThenElse(all_usable, gx, blend(e[0].a, e[1].a, e[2].a));
        gy = hn::IfThenElse(all_usable, gy, blend(e[0].b, e[1].b, e[2].b));
        g0 = hn::IfThenElse(all_usable, g0, blend(plain_c[0], plain_c[1], plain_c[2]));
    }

    // A triangle no wider than its edges' rounding is a line: along it they say nothing of where it ends, nor does its
    // plane of how far it is. Then its pixels are those of its bounds, and its depth is that of its longest edge.
    const VF rounding = hn::Add(e[0].error, hn::Add(e[1].error, e[2].error));
    const MF thin = hn::And(all_usable, hn::Lt(hn::Abs(area), hn::Mul(rounding, hn::Set(f, kThin))));
    if (HWY_UNLIKELY(!hn::AllFalse(f, thin))) {
        const VF bcx = hn::Sub(p[2].x, p[1].x), bcy = hn::Sub(p[2].y, p[1].y);
        const auto squared = [](VF x, VF y) { return hn::MulAdd(x, x, hn::Mul(y, y)); };
        const VF ab2 = squared(abx, aby), ac2 = squared(acx, acy), bc2 = squared(bcx, bcy);
        const MF ac_longer = hn::Gt(ac2, ab2);
        VF x = hn::IfThenElse(ac_longer, acx, abx), y = hn::IfThenElse(ac_longer, acy, aby);
        VF rise = hn::IfThenElse(ac_longer, ac, ab), length2 = hn::Max(ac2, ab2);
        const MF bc_longest = hn::Gt(bc2, length2);
        x = hn::IfThenElse(bc_longest, bcx, x);
        y = hn::IfThenElse(bc_longest, bcy, y);
        rise = hn::IfThenElse(bc_longest, hn::Sub(p[2].iw, p[1].iw), rise);
        length2 = hn::IfThenElse(bc_longest, bc2, length2);
        const Corner& b = p[1];
        const VF start_x = hn::IfThenElse(bc_longest, b.x, p[0].x), start_y = hn::IfThenElse(bc_longest, b.y, p[0].y);
        const VF start = hn::IfThenElse(bc_longest, b.iw, p[0].iw);
        const VF slope = hn::Div(rise, length2);
        gx = hn::IfThenElse(thin, hn::Mul(slope, x), gx);
        gy = hn::IfThenElse(thin, hn::Mul(slope, y), gy);
        g0 = hn::IfThenElse(thin, hn::NegMulAdd(gx, start_x, hn::NegMulAdd(gy, start_y, start)), g0);
    }
    hn::Store(hn::IfThenElseZero(thin, hn::Set(f, 1.0f)), f, s.thin + first);
    if constexpr (kByDepth) {
        // Distant triangles have bounds of a pixel or two. Those are asked here, many triangles at once, with the very
        // operations of the rows: most win none.
        const MF is_small = hn::Le(hn::Add(hn::Sub(x1, x0), hn::Sub(y1, y0)), hn::Set(f, 1.0f));
        if (!hn::AllFalse(f, hn::And(alive, is_small))) {
            const auto may_win = [&](VF column, VF row) {
                const VF x = hn::Sub(column, half), y = hn::Sub(row, half);
                const auto value = [&](VF a, VF b, VF c) { return hn::MulAdd(b, y, hn::MulAdd(a, x, c)); };
                const VF inside =
                    min3(value(e[0].a, e[0].b, e[0].c), value(e[1].a, e[1].b, e[1].c), value(e[2].a, e[2].b, e[2].c));
                const VF inverse_depth = hn::Min(hn::Max(value(gx, gy, g0), low), high);
                const VI at = integer_of(hn::MulAdd(row, hn::Set(f, float(kRowStride)), column));
                const VF best = hn::GatherIndex(f, tile.best, hn::IfThenElseZero(hn::RebindMask(si, alive), at));
                return hn::And(hn::Ge(inside, hn::Zero(f)), hn::Ge(inverse_depth, best));
            };
            alive = hn::And(alive, hn::Or(hn::Not(is_small), hn::Or(may_win(x0, y0), may_win(x1, y1))));
        }
    }
    const std::uint32_t bits = bits_of(alive);

    for (int k = 0; k < 3; ++k) {
        hn::Store(e[k].a, f, s.a[k] + first);
        hn::Store(e[k].b, f, s.b[k] + first);
        hn::Store(kWidened ? e[k].c : plain_c[k], f, s.c[k] + first);
        hn::Store(scale[k], f, s.weight[k] + first);
        if constexpr (kWidened) hn::Store(e[k].error, f, s.widening[k] + first);
    }
    hn::Store(gx, f, s.gx + first);
    hn::Store(gy, f, s.gy + first);
    hn::Store(g0, f, s.g0 + first);
    hn::Store(low, f, s.low + first);
    hn::Store(high, f, s.high + first);
    hn::Store(integer_of(x0), si, s.x0 + first);
    hn::Store(integer_of(x1), si, s.x1 + first);
    hn::Store(integer_of(y0), si, s.y0 + first);
    hn::Store(integer_of(y1), si, s.y1 + first);
    return bits << first;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
