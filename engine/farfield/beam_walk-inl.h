// A tile's beam through one 16-wide hierarchy, front to back. Compiled once per SIMD target; include after
// <hwy/highway.h>.
#if defined(FF_BEAM_WALK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_BEAM_WALK_INL_H_
#undef FF_BEAM_WALK_INL_H_
#else
#define FF_BEAM_WALK_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/farfield/beam_tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

constexpr int kStackEntries = 2048;  // 15 per level of a tree; the builder keeps trees below 132 levels

// The low four bits of `near` name the quarters of the tile that the child touches; cutting them off only brings it
// nearer.
struct StackEntry {
    float near;
    std::uint32_t child;
    [[nodiscard]] std::uint32_t quarters() const { return std::bit_cast<std::uint32_t>(near) & 15u; }
};

// The beam in the space of one hierarchy, as linear functions of which one corner of a box is asked: four planes that
// look inwards, least depth, and least and greatest X W and Y W. `row` says which of a node's six rows (low x y z, high
// x y z) holds that corner.
struct Beam {
    enum : int { kNear = 4, kLeft, kRight, kTop, kBottom, kCount };
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
    Linear near = w;
    near.c -= rounding_over(w, reach);
    set_plane(beam, Beam::kNear, near, false);
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

// Children that the beam meets, as bits; those that reach into a half of the tile; their least depths.
struct Met {
    std::uint32_t all = 0, left = 0, right = 0, top = 0, bottom = 0;
    alignas(64) float near[16];
};

HWY_INLINE void children_in_beam(const BvhNode& node, const Beam& beam, float far, Met& met) {
    for (int i = 0; i < 16; i += kLanes) {
        const float* lanes = node.low_x + i;
        // An empty lane gives -inf or, where a normal has a zero, not-a-number; neither is >= 0.
        const VF inside = hn::Min(hn::Min(corner_value(beam, 0, lanes), corner_value(beam, 1, lanes)),
                                  hn::Min(corner_value(beam, 2, lanes), corner_value(beam, 3, lanes)));
        const VF depth = corner_value(beam, Beam::kNear, lanes), zero = hn::Zero(f);
        hn::Store(depth, f, met.near + i);
        const std::uint32_t bits = bits_of(hn::And(hn::Ge(inside, zero), hn::Lt(depth, hn::Set(f, far))));
        if (bits == 0) continue;
        met.all |= bits << i;
        met.left |= bits_of(hn::Le(corner_value(beam, Beam::kLeft, lanes), zero)) << i;
        met.right |= bits_of(hn::Ge(corner_value(beam, Beam::kRight, lanes), zero)) << i;
        met.top |= bits_of(hn::Le(corner_value(beam, Beam::kTop, lanes), zero)) << i;
        met.bottom |= bits_of(hn::Ge(corner_value(beam, Beam::kBottom, lanes), zero)) << i;
    }
}

HWY_INLINE void prefetch(const void* address) {
    const char* at = static_cast<const char*>(address);
    for (int line = 0; line < 7; ++line) __builtin_prefetch(at + 64 * line);
}

// Walks one hierarchy front to back; `on_leaf(leaf id)` may bring `tile.far` nearer.
template <class Prefetch, class OnLeaf>
HWY_INLINE void walk(const BvhNode* nodes, const Beam& beam, const Tile& tile, std::uint64_t& visited,
                     Prefetch&& prefetch_child, OnLeaf&& on_leaf) {
    StackEntry stack[kStackEntries];
    int top = 0;
    stack[top++] = {std::bit_cast<float>(15u), 0};
    while (top > 0) {
        const StackEntry entry = stack[--top];
        if (!(entry.near < tile.far[entry.quarters()])) continue;
        if (entry.child & kBvhLeafBit) {
            on_leaf(entry.child & ~kBvhLeafBit);
            continue;
        }
        const BvhNode& node = nodes[entry.child];
        ++visited;
        Met met;
        children_in_beam(node, beam, tile.far[15], met);
        if (top + scene::kBvhWidth > kStackEntries) continue;  // no tree of ours is that deep
        const int bottom = top;
        for (; met.all != 0; met.all &= met.all - 1) {
            const int lane = std::countr_zero(met.all);
            const auto half = [lane](std::uint32_t bits, std::uint32_t quarters) {
                return (0u - ((bits >> lane) & 1u)) & quarters;
            };
            const std::uint32_t quarters =
                (half(met.left, 0b0101) | half(met.right, 0b1010)) & (half(met.top, 0b0011) | half(met.bottom, 0b1100));
            const std::uint32_t near = (std::bit_cast<std::uint32_t>(met.near[lane]) & ~15u) | quarters;
            const StackEntry child{std::bit_cast<float>(near), node.child[lane]};
            if (!(child.near < tile.far[quarters])) continue;
            prefetch_child(child.child);
            int at = top++;
            for (; at > bottom && stack[at - 1].near < child.near; --at) stack[at] = stack[at - 1];
            stack[at] = child;
        }
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
