// A tile's beam through one 16-wide hierarchy, front to back. Compiled once per SIMD target; include after
// <hwy/highway.h>.
#if defined(FF_BEAM_WALK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_BEAM_WALK_INL_H_
#undef FF_BEAM_WALK_INL_H_
#else
#define FF_BEAM_WALK_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/farfield/beam_tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

constexpr int kAhead = 8;            // children on the stack that memory is asked for
constexpr int kStackEntries = 2048;  // 15 per level of a tree; the builder keeps trees below 132 levels

// Pixels of the tile: columns x0..x1 and rows y0..y1, five bits each from the lowest on; then the rectangle of cells
// that they touch, eight bits.
struct PixelRect {
    static constexpr std::uint32_t kWholeTile = 0xCCu << 20 | 31u << 15 | 31u << 5;
    std::uint32_t packed;
    [[nodiscard]] std::uint32_t x0() const { return packed & 31u; }
    [[nodiscard]] std::uint32_t x1() const { return packed >> 5 & 31u; }
    [[nodiscard]] std::uint32_t y0() const { return packed >> 10 & 31u; }
    [[nodiscard]] std::uint32_t y1() const { return packed >> 15 & 31u; }
    [[nodiscard]] std::uint32_t cells() const { return packed >> 20 & 255u; }
};

struct StackEntry {
    float near;
    std::uint32_t child;
    PixelRect rect;  // what of the tile the child may cover
};

// The beam in the space of one hierarchy, as linear functions of which one corner of a box is asked: four planes that
// look inwards, least and greatest depth, and least and greatest X W and Y W. `row` says which of a node's six rows
// (low x y z, high x y z) holds that corner.
struct Beam {
    enum : int { kNear = 4, kFar, kLeft, kRight, kTop, kBottom, kCount };
    float x[kCount], y[kCount], z[kCount], c[kCount];
    std::uint32_t row_x[kCount], row_y[kCount], row_z[kCount];
};

// Largest value that rounding may take from a linear function over a box.
HWY_INLINE float rounding_over(const Linear& l, const Vec3& reach) {
    return kBoxError * (std::abs(l.x) * reach.x + std::abs(l.y) * reach.y + std::abs(l.z) * reach.z + std::abs(l.c));
}

HWY_INLINE void set_plane(Beam& beam, int plane, const Linear& l, bool upper) {
    beam.x[plane] = l.x;
    beam.y[plane] = l.y;
    beam.z[plane] = l.z;
    beam.c[plane] = l.c;
    beam.row_x[plane] = ((l.x > 0.0f) == upper ? 3 : 0) * 16;
    beam.row_y[plane] = ((l.y > 0.0f) == upper ? 4 : 1) * 16;
    beam.row_z[plane] = ((l.z > 0.0f) == upper ? 5 : 2) * 16;
}

// @param reach  largest absolute coordinate of the hierarchy's boxes.
HWY_INLINE Beam make_beam(const Linear (&xyw)[3], const Vec3& reach, const Tile& tile) {
    Beam beam;
    const float bounds[4] = {tile.first_column - kHalf - kPlaneMargin, tile.last_column - kHalf + kPlaneMargin,
                             tile.first_row - kHalf - kPlaneMargin, tile.last_row - kHalf + kPlaneMargin};
    const Linear& w = xyw[2];
    for (int plane = 0; plane < 4; ++plane) {
        const Linear& p = xyw[plane / 2];
        const float s = plane % 2 == 0 ? 1.0f : -1.0f, b = bounds[plane];
        Linear l{s * (p.x - b * w.x), s * (p.y - b * w.y), s * (p.z - b * w.z), s * (p.c - b * w.c)};
        l.c += rounding_over(p, reach) + std::abs(b) * rounding_over(w, reach);
        set_plane(beam, plane, l, true);
    }
    for (int side = 0; side < 2; ++side) {
        Linear l = w;
        l.c += side == 0 ? -rounding_over(w, reach) : rounding_over(w, reach);
        set_plane(beam, Beam::kNear + side, l, side == 1);
    }
    for (int side = 0; side < 4; ++side) {
        Linear l = xyw[side / 2];
        const bool upper = side % 2 == 1;
        l.c += upper ? rounding_over(l, reach) : -rounding_over(l, reach);
        set_plane(beam, Beam::kLeft + side, l, upper);
    }
    return beam;
}

HWY_INLINE VF corner_value(const Beam& beam, int plane, const float* lanes) {
    const VF z =
        hn::MulAdd(hn::Set(f, beam.z[plane]), hn::Load(f, lanes + beam.row_z[plane]), hn::Set(f, beam.c[plane]));
    const VF y = hn::MulAdd(hn::Set(f, beam.y[plane]), hn::Load(f, lanes + beam.row_y[plane]), z);
    return hn::MulAdd(hn::Set(f, beam.x[plane]), hn::Load(f, lanes + beam.row_x[plane]), y);
}

// Children that the beam meets, as bits; their least depths, and the pixels whose centres their boxes may cover.
struct Met {
    std::uint32_t all = 0;
    alignas(64) float near[16];
    alignas(64) std::uint32_t rect[16];
};

// The tile's pixels, as numbers.
struct TileBounds {
    VI x0, x1, y0, y1;
    explicit HWY_INLINE TileBounds(const Tile& tile)
        : x0(hn::Set(si, int(tile.first_column))),
          x1(hn::Set(si, int(tile.last_column))),
          y0(hn::Set(si, int(tile.first_row))),
          y1(hn::Set(si, int(tile.last_row))) {}
};

// First and last pixel whose centre lies in [low / W, high / W] for any W of [near, far]. Tile space has its origin in
// the tile, so that a distant box's extent in depth hardly widens this.
HWY_INLINE void covered_centres(VF low, VF high, VF per_near, VF per_far, VI& first, VI& last) {
    const VF zero = hn::Zero(f), centre = hn::Set(f, kHalf);
    const VF from = hn::Mul(low, hn::IfThenElse(hn::Lt(low, zero), per_near, per_far));
    const VF to = hn::Mul(high, hn::IfThenElse(hn::Lt(high, zero), per_far, per_near));
    // Beyond the tile all numbers are the same; conversion wants them small.
    const VF least = hn::Set(f, -1.0f), most = hn::Set(f, float(kBeamSize + 1));
    const VF begin = hn::Clamp(hn::Add(from, hn::Sub(centre, hn::Set(f, kPlaneMargin))), least, most);
    const VF end = hn::Clamp(hn::Add(to, hn::Add(centre, hn::Set(f, kPlaneMargin))), least, most);
    first = hn::Max(first, integer_of(hn::Ceil(begin)));
    last = hn::Min(last, integer_of(hn::Floor(end)));
}

// PixelRects.
HWY_INLINE VI pack(VI x0, VI x1, VI y0, VI y1) {
    const auto cell = [](VI pixel) { return hn::ShiftRight<3>(pixel); };
    const VI columns = range_of_cells(cell(x0), cell(x1)), rows = range_of_cells(cell(y0), cell(y1));
    const VI cells = hn::Or(columns, hn::ShiftLeft<4>(rows));
    return hn::Or(hn::Or(hn::Or(x0, hn::ShiftLeft<5>(x1)), hn::Or(hn::ShiftLeft<10>(y0), hn::ShiftLeft<15>(y1))),
                  hn::ShiftLeft<20>(cells));
}

HWY_INLINE void children_in_beam(const BvhNode& node, const Beam& beam, const TileBounds& bounds, const Tile& tile,
                                 Met& met) {
    const float least = tile.least(PixelRect{PixelRect::kWholeTile}.cells());
    for (int i = 0; i < 16; i += kLanes) {
        const float* lanes = node.low_x + i;
        // An empty lane gives -inf or, where a normal has a zero, not-a-number; neither is >= 0.
        const VF inside = hn::Min(hn::Min(corner_value(beam, 0, lanes), corner_value(beam, 1, lanes)),
                                  hn::Min(corner_value(beam, 2, lanes), corner_value(beam, 3, lanes)));
        const VF near = corner_value(beam, Beam::kNear, lanes), zero = hn::Zero(f);
        hn::Store(near, f, met.near + i);
        const MF nearer = hn::Lt(hn::Mul(near, hn::Set(f, least)), hn::Set(f, kFarther));
        const MF met_beam = hn::And(hn::Ge(inside, zero), nearer);
        if (hn::AllFalse(f, met_beam)) continue;
        const VF far = corner_value(beam, Beam::kFar, lanes);
        // Most boxes far away are smaller than a pixel, and most of those lie between the pixels' centres.
        const MF before_eye = hn::Gt(near, hn::Set(f, kMinW));
        const VF one = hn::Set(f, 1.0f);
        const VF per_near = hn::Div(one, hn::IfThenElse(before_eye, near, one));
        const VF per_far = hn::Div(one, hn::IfThenElse(before_eye, far, one));
        VI x0 = bounds.x0, x1 = bounds.x1, y0 = bounds.y0, y1 = bounds.y1;
        covered_centres(corner_value(beam, Beam::kLeft, lanes), corner_value(beam, Beam::kRight, lanes), per_near,
                        per_far, x0, x1);
        covered_centres(corner_value(beam, Beam::kTop, lanes), corner_value(beam, Beam::kBottom, lanes), per_near,
                        per_far, y0, y1);
        // A box that reaches behind the eye may cover everything.
        const auto whole = hn::RebindMask(si, hn::Not(before_eye));
        x0 = hn::IfThenElse(whole, bounds.x0, x0), x1 = hn::IfThenElse(whole, bounds.x1, x1);
        y0 = hn::IfThenElse(whole, bounds.y0, y0), y1 = hn::IfThenElse(whole, bounds.y1, y1);
        const MF covers = hn::RebindMask(f, hn::Not(hn::Or(hn::Gt(x0, x1), hn::Gt(y0, y1))));
        const VI rect = pack(x0, x1, y0, y1);
        const VF seen = hn::GatherIndex(f, tile.best + kLeast, hn::And(hn::ShiftRight<20>(rect), hn::Set(si, 255)));
        const MF not_before = hn::Ge(far, hn::Set(f, tile.begin));
        const MF is_met =
            hn::And(hn::And(met_beam, not_before), hn::And(covers, hn::Lt(hn::Mul(near, seen), hn::Set(f, kFarther))));
        met.all |= bits_of(is_met) << i;
        hn::Store(hn::BitCast(ui, rect), ui, met.rect + i);
    }
}

// How many of the children met are farther than that of a lane; of those equally far, the lower lanes count.
HWY_INLINE int farther_than(const Met& met, int lane) {
    std::uint32_t farther = 0, equal = 0;
    const VF own = hn::Set(f, met.near[lane]);
    for (int i = 0; i < 16; i += kLanes) {
        const VF near = hn::Load(f, met.near + i);
        farther |= bits_of(hn::Gt(near, own)) << i;
        equal |= bits_of(hn::Eq(near, own)) << i;
    }
    return std::popcount((farther | (equal & ((1u << lane) - 1u))) & met.all);
}

// Whether something in these pixels, nowhere nearer than `near`, could still be seen: by the farthest of the cells that
// they touch.
HWY_INLINE bool may_be_seen_in_cells(const Tile& tile, float near, PixelRect rect) {
    return near * tile.least(rect.cells()) < kFarther;
}

// The same by each of the pixels. What may be seen mostly may in one of the first rows; what may not saves more than
// all of them cost.
HWY_INLINE bool may_be_seen_in_pixels(const Tile& tile, float near, PixelRect rect) {
    const VF nearest = hn::Set(f, near), farther = hn::Set(f, kFarther);
    for (std::uint32_t column = rect.x0(); column <= rect.x1(); column += kLanes) {
        const MF inside = hn::FirstN(f, rect.x1() - column + 1);
        const float* best = tile.best + rect.y0() * std::uint32_t(kRowStride) + column;
        for (std::uint32_t row = rect.y0(); row <= rect.y1(); ++row, best += kRowStride) {
            const MF seen = hn::Lt(hn::Mul(nearest, hn::LoadU(f, best)), farther);
            if (!hn::AllFalse(f, hn::And(seen, inside))) return true;
        }
    }
    return false;
}

template <class T>
HWY_INLINE void prefetch(const T* object) {
    const char* at = reinterpret_cast<const char*>(object);
    for (std::size_t byte = 0; byte < sizeof(T); byte += 64) __builtin_prefetch(at + byte);
}

// Every child of every node, for walk().
struct AllChildren {
    constexpr std::uint32_t operator()(std::uint32_t) const { return 0xFFFFu; }
};

// Walks one hierarchy front to back; `on_leaf(leaf id)` may bring pixels nearer.
// @param prefetch_child  asks memory for a child that will be looked at before long
// @param children_of     which children of a node count, as bits
template <class Prefetch, class OnLeaf, class ChildrenOf = AllChildren>
HWY_INLINE void walk(const BvhNode* nodes, const Beam& beam, const Tile& tile, std::uint64_t& visited,
                     Prefetch&& prefetch_child, OnLeaf&& on_leaf, ChildrenOf&& children_of = {}) {
    const TileBounds bounds(tile);
    StackEntry stack[kStackEntries];
    int top = 0;
    stack[top++] = {0.0f, 0, {PixelRect::kWholeTile}};
    while (top > 0) {
        const StackEntry entry = stack[--top];
        if (top >= kAhead) prefetch_child(stack[top - kAhead].child);
        if (!may_be_seen_in_cells(tile, entry.near, entry.rect)) continue;
        if (!may_be_seen_in_pixels(tile, entry.near, entry.rect)) continue;
        if (entry.child & kBvhLeafBit) {
            on_leaf(entry.child & ~kBvhLeafBit);
            continue;
        }
        const BvhNode& node = nodes[entry.child];
        ++visited;
        Met met;
        children_in_beam(node, beam, bounds, tile, met);
        met.all &= children_of(entry.child);
        if (top + scene::kBvhWidth > kStackEntries) continue;  // no tree of ours is that deep
        // The nearest comes to lie on top. Where each belongs is counted, not searched: no branch to be guessed.
        for (std::uint32_t left = met.all; left != 0; left &= left - 1) {
            const int lane = std::countr_zero(left);
            stack[top + farther_than(met, lane)] = {met.near[lane], node.child[lane], {met.rect[lane]}};
        }
        const int first = top;
        top += std::popcount(met.all);
        // What is needed first is asked for first, and no more than memory can bring at once.
        for (int i = top; i-- > std::max(first, top - kAhead);) prefetch_child(stack[i].child);
    }
}

HWY_INLINE Vec3 reach_of(const Vec3& low, const Vec3& high) {
    return glm::max(glm::abs(low), glm::abs(high));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
