// One tile of 16 x 16 pixels at once: its beam walks the instances' hierarchy and each mesh's, front to back, against
// its planes and the farthest depth that it still has; leaves are set up and culled a register of triangles at a time,
// survivors go through edge functions over the rows that they cover; the nearest stays, on a tie the smaller
// (instance, triangle).
//
// Based on: Olano, Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", HWWS 1997 (edge functions that
// need no clipping; here only for edges near or behind the eye plane, where projected ones fail; the others are
// projected first, because small distant triangles lose their shape in homogeneous cross products).
//
// No cracks: an edge function depends on its two vertices alone, changes its sign exactly with their order, and is
// widened by its own rounding error. So whatever lies in the closed triangles of tile-space vertices is found; what
// lies within that error of an edge is found twice, and depth decides.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/beam_caster_tile.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/farfield/beam_caster.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using scene::BvhLeaf;
using scene::BvhNode;
using scene::kBvhLeafBit;

using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using MF = hn::Mask<F>;
constexpr F f;
constexpr I si;
constexpr U ui;
constexpr int kLanes = int(hn::MaxLanes(f));

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kHalf = 7.5f;           // the outermost pixel centres
constexpr float kPlaneMargin = 0.01f;   // pixels by which the beam is wider
constexpr float kBoundsMargin = 1e-3f;  // pixels by which a triangle's bounds are wider
constexpr float kMinW = 1e-4f;          // metres; nearer vertices count as crossing the eye plane
constexpr float kMaxProjected = 1024;   // pixels from the tile; vertices further out are not projected
constexpr float kEdgeError = 4e-7f;     // rounding of an edge function, relative to its largest terms
constexpr float kBoxError = 5e-7f;      // rounding of a plane at a box corner, likewise
constexpr float kNearestInverse = 1e9f;

constexpr int kStackEntries = 2048;  // 15 per level of a tree; the builder keeps trees below 132 levels

// The low four bits of `near` name the quarters of the tile that the child touches; cutting them off only brings it
// nearer.
struct StackEntry {
    float near;
    std::uint32_t child;
    [[nodiscard]] std::uint32_t quarters() const { return std::bit_cast<std::uint32_t>(near) & 15u; }
};

// W, X W or Y W of a point as a linear function.
struct Linear {
    float x, y, z, c;
};

// The beam in the space of one hierarchy, as linear functions of which one corner of a box is asked: four planes that
// look inwards, least depth, and least and greatest X W and Y W. `row` says which of a node's six rows (low x y z, high
// x y z) holds that corner.
struct Beam {
    enum : int { kNear = 4, kLeft, kRight, kTop, kBottom, kCount };
    float x[kCount], y[kCount], z[kCount], c[kCount];
    std::uint32_t row_x[kCount], row_y[kCount], row_z[kCount];
};

struct alignas(64) LeafScratch {
    float x[32], y[32], iw[32];    // projected
    float hx[32], hy[32], hw[32];  // homogeneous; filled only where a vertex cannot be projected
    float a[3][16], b[3][16], c[3][16];
    float gx[16], gy[16], g0[16];  // 1/depth as a plane over the tile
    float low[16], high[16];       // its range over the triangle
    float weight[3][16];           // edge function to (unnormalised) barycentric
    std::int32_t x0[16], x1[16], y0[16], y1[16];
};

struct Tile {
    alignas(64) float best[256];  // 1/depth; 0: sky; +inf where nobody asked
    alignas(64) std::uint32_t instance[256];
    alignas(64) std::uint32_t triangle[256];
    float quarter_best[4] = {};  // of the farthest pixel of each 8 x 8: top left, top right, bottom left, bottom right
    float far[16];               // depth of the farthest pixel in any set of quarters, rounded up
    float first_column = 0, last_column = 15, first_row = 0, last_row = 15;  // bounds of the pixels asked for
    bool changed = false;
};

// ---- Traversal

HWY_INLINE Linear linear_of(const DMat3& tile_from_world, int row, const DMat3& world_from_mesh, const DVec3& offset) {
    const DVec3 r(tile_from_world[0][row], tile_from_world[1][row], tile_from_world[2][row]);
    return {float(glm::dot(r, world_from_mesh[0])), float(glm::dot(r, world_from_mesh[1])),
            float(glm::dot(r, world_from_mesh[2])), float(glm::dot(r, offset))};
}

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

HWY_INLINE std::uint32_t bits_of(MF mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(f, mask, bytes);
    return kLanes > 8 ? std::uint32_t(bytes[0] | bytes[1] << 8) : std::uint32_t(bytes[0]);
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

// ---- Leaves

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

// Fills the tile-space vertices; true when all of them could be projected.
HWY_INLINE bool transform_vertices(const BvhLeaf& leaf, const Linear (&xyw)[3], LeafScratch& s) {
    MF projected = hn::MaskFromVec(hn::BitCast(f, hn::Set(si, -1)));
    const VF limit = hn::Set(f, kMaxProjected);
    for (int v = 0; v < leaf.vertex_count; v += kLanes) {
        const VF x = hn::Load(f, leaf.x + v), y = hn::Load(f, leaf.y + v), z = hn::Load(f, leaf.z + v);
        const auto apply = [&](const Linear& l) {
            return hn::MulAdd(hn::Set(f, l.x), x,
                              hn::MulAdd(hn::Set(f, l.y), y, hn::MulAdd(hn::Set(f, l.z), z, hn::Set(f, l.c))));
        };
        const VF hx = apply(xyw[0]), hy = apply(xyw[1]), hw = apply(xyw[2]);
        const VF iw = hn::Div(hn::Set(f, 1.0f), hw);
        const VF px = hn::Mul(hx, iw), py = hn::Mul(hy, iw);
        projected = hn::And(projected, hn::And(hn::Gt(hw, hn::Set(f, kMinW)),
                                               hn::And(hn::Le(hn::Abs(px), limit), hn::Le(hn::Abs(py), limit))));
        hn::Store(px, f, s.x + v);
        hn::Store(py, f, s.y + v);
        hn::Store(iw, f, s.iw + v);
        hn::Store(hx, f, s.hx + v);
        hn::Store(hy, f, s.hy + v);
        hn::Store(hw, f, s.hw + v);
    }
    return hn::AllTrue(f, projected);
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

HWY_INLINE Edge projected_edge(const Corner& p, const Corner& q) {
    const VF u = hn::Mul(p.x, q.y), v = hn::Mul(p.y, q.x);
    Edge e{hn::Sub(p.y, q.y), hn::Sub(q.x, p.x), hn::Sub(u, v), hn::Zero(f)};
    const VF terms =
        hn::Add(hn::Add(hn::Abs(u), hn::Abs(v)), hn::Mul(hn::Add(hn::Abs(e.a), hn::Abs(e.b)), hn::Set(f, 8.0f)));
    e.error = hn::Mul(terms, hn::Set(f, kEdgeError));
    return e;
}

HWY_INLINE Edge homogeneous_edge(const Corner& p, const Corner& q) {
    const VF a0 = hn::Mul(p.hy, q.hw), a1 = hn::Mul(p.hw, q.hy);
    const VF b0 = hn::Mul(p.hw, q.hx), b1 = hn::Mul(p.hx, q.hw);
    const VF c0 = hn::Mul(p.hx, q.hy), c1 = hn::Mul(p.hy, q.hx);
    Edge e{hn::Sub(a0, a1), hn::Sub(b0, b1), hn::Sub(c0, c1), hn::Zero(f)};
    const VF ab = hn::Add(hn::Add(hn::Abs(a0), hn::Abs(a1)), hn::Add(hn::Abs(b0), hn::Abs(b1)));
    const VF terms = hn::MulAdd(ab, hn::Set(f, 8.0f), hn::Add(hn::Abs(c0), hn::Abs(c1)));
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

// The farthest 1/depth that the tile still has in the quarters that bounds in pixels touch.
HWY_INLINE VF farthest_under(VF x0, VF x1, VF y0, VF y1, const Tile& tile) {
    const VF middle = hn::Set(f, 8.0f), none = hn::Set(f, kInf);
    const MF left = hn::Lt(x0, middle), right = hn::Ge(x1, middle);
    const auto of_row = [&](int quarter) {
        return hn::Min(hn::IfThenElse(left, hn::Set(f, tile.quarter_best[quarter]), none),
                       hn::IfThenElse(right, hn::Set(f, tile.quarter_best[quarter + 1]), none));
    };
    return hn::Min(hn::IfThenElse(hn::Lt(y0, middle), of_row(0), none),
                   hn::IfThenElse(hn::Ge(y1, middle), of_row(2), none));
}

// Sets up kLanes triangles from `first` on; returns those that may win a pixel, as bits.
// @tparam kProjected  every vertex of the leaf can be projected.
// @tparam kDirect     the leaf's vertices lie as registers need them.
template <bool kProjected, bool kDirect>
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
        const VF everywhere = hn::Set(f, 15.0f);
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
    alive = hn::And(alive, hn::Ge(high, farthest_under(x0, x1, y0, y1, tile)));
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
        const VF det =
            hn::MulAdd(p[0].hx, hn::Sub(hn::Mul(p[1].hy, p[2].hw), hn::Mul(p[1].hw, p[2].hy)),
                       hn::MulAdd(p[0].hy, hn::Sub(hn::Mul(p[1].hw, p[2].hx), hn::Mul(p[1].hx, p[2].hw)),
                                  hn::Mul(p[0].hw, hn::Sub(hn::Mul(p[1].hx, p[2].hy), hn::Mul(p[1].hy, p[2].hx)))));
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
        const VF most = hn::MulAdd(e[k].a, best_x, hn::MulAdd(e[k].b, best_y, e[k].c));
        alive = hn::And(alive, hn::Ge(most, hn::Zero(f)));
    }
    const std::uint32_t bits = bits_of(alive);
    if (bits == 0) return 0;

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

    for (int k = 0; k < 3; ++k) {
        hn::Store(e[k].a, f, s.a[k] + first);
        hn::Store(e[k].b, f, s.b[k] + first);
        hn::Store(e[k].c, f, s.c[k] + first);
        hn::Store(scale[k], f, s.weight[k] + first);
    }
    hn::Store(gx, f, s.gx + first);
    hn::Store(gy, f, s.gy + first);
    hn::Store(g0, f, s.g0 + first);
    hn::Store(low, f, s.low + first);
    hn::Store(high, f, s.high + first);
    hn::Store(hn::ConvertTo(si, x0), si, s.x0 + first);
    hn::Store(hn::ConvertTo(si, x1), si, s.x1 + first);
    hn::Store(hn::ConvertTo(si, y0), si, s.y0 + first);
    hn::Store(hn::ConvertTo(si, y1), si, s.y1 + first);
    return bits << first;
}

// ---- Rows

// A see-through triangle, looked up once one of its pixels may win.
struct AlphaDraw {
    const scene::StaticScene& scene;
    std::uint32_t instance, triangle;
    float pixel_angle;
    bool is_known = false;
    AlphaSurface surface;
};

HWY_INLINE VI texel_of(VF coordinate, std::uint32_t size, scene::Wrap wrap) {
    VF c = coordinate;
    if (wrap == scene::Wrap::repeat) {
        c = hn::Sub(c, hn::Floor(c));
    } else if (wrap == scene::Wrap::mirror) {
        c = hn::Sub(c, hn::Mul(hn::Set(f, 2.0f), hn::Floor(hn::Mul(hn::Set(f, 0.5f), c))));
        c = hn::IfThenElse(hn::Gt(c, hn::Set(f, 1.0f)), hn::Sub(hn::Set(f, 2.0f), c), c);
    }
    const VF texel = hn::Max(hn::Mul(c, hn::Set(f, float(size))), hn::Zero(f));  // not-a-number becomes 0
    return hn::ConvertTo(si, hn::Min(texel, hn::Set(f, float(size - 1))));
}

HWY_INLINE VF threshold_of(std::uint32_t seed, VI x, VI y) {
    auto h = hn::Xor(hn::Set(ui, seed), hn::Xor(hn::Mul(hn::BitCast(ui, x), hn::Set(ui, 0x9E3779B1u)),
                                                hn::Mul(hn::BitCast(ui, y), hn::Set(ui, 0x85EBCA77u))));
    h = hn::Mul(hn::Xor(h, hn::ShiftRight<15>(h)), hn::Set(ui, 0x2C1B3C6Du));
    h = hn::Mul(hn::Xor(h, hn::ShiftRight<12>(h)), hn::Set(ui, 0x297A2D39u));
    h = hn::Xor(h, hn::ShiftRight<15>(h));
    const VI k = hn::Add(hn::BitCast(si, hn::ShiftRight<8>(h)), hn::Set(si, 1));
    return hn::Mul(hn::ConvertTo(f, k), hn::Set(f, 1.0f / 16777216.0f));
}

// Switches off the lanes of `win` whose point is see-through: is_opaque_at() of alpha_test.h, operation by operation,
// for a register of pixels. e: their edge functions.
HWY_NOINLINE MF opaque_lanes(MF win, AlphaDraw& draw, const LeafScratch& s, int i, const VF (&e)[3], VF inverse_depth) {
    if (!draw.is_known) {
        const scene::Instance& instance = draw.scene.instances[draw.instance];
        draw.surface = make_alpha_surface(draw.scene, instance, draw.instance, draw.triangle);
        draw.is_known = true;
    }
    const AlphaSurface& surface = draw.surface;
    if (!surface.is_see_through) return win;
    const VF w0 = hn::Mul(e[0], hn::Set(f, s.weight[0][i])), w1 = hn::Mul(e[1], hn::Set(f, s.weight[1][i]));
    const VF w2 = hn::Mul(e[2], hn::Set(f, s.weight[2][i]));
    const VF inverse_sum = hn::Div(hn::Set(f, 1.0f), hn::Add(w0, hn::Add(w1, w2)));
    const VF b1 = hn::Mul(w1, inverse_sum), b2 = hn::Mul(w2, inverse_sum);
    const VF b0 = hn::Sub(hn::Sub(hn::Set(f, 1.0f), b1), b2);
    const VF footprint = hn::Div(hn::Set(f, draw.pixel_angle), inverse_depth);
    const auto mix = [&](float v0, float v1, float v2) {
        return hn::Add(hn::Add(hn::Mul(hn::Set(f, v0), b0), hn::Mul(hn::Set(f, v1), b1)), hn::Mul(hn::Set(f, v2), b2));
    };
    VF alpha = mix(surface.alpha[0], surface.alpha[1], surface.alpha[2]);
    VI x, y;
    if (surface.texture != nullptr) {
        const scene::Texture& texture = *surface.texture;
        const VF texels = hn::Max(hn::Mul(footprint, hn::Set(f, surface.texels_per_m)), hn::Set(f, 1.0f));
        const VI octave = hn::Sub(hn::ShiftRight<23>(hn::BitCast(si, texels)), hn::Set(si, 127));
        const VI levels = hn::Min(octave, hn::Set(si, std::int32_t(texture.level_count - 1)));
        const VF u = mix(surface.uv[0].x, surface.uv[1].x, surface.uv[2].x);
        const VF v = mix(surface.uv[0].y, surface.uv[1].y, surface.uv[2].y);
        // Mostly all pixels are on one level; a register is done level by level.
        alignas(64) std::int32_t level_of[16];
        hn::Store(levels, si, level_of);
        VF texture_alpha = hn::Zero(f);
        x = y = hn::Zero(si);
        for (std::uint32_t left = bits_of(win); left != 0;) {
            const std::int32_t level = level_of[std::countr_zero(left)];
            const MF here = hn::RebindMask(f, hn::Eq(levels, hn::Set(si, level)));
            left &= ~bits_of(here);
            const std::uint32_t width = std::max(1u, texture.width >> level);
            const VI level_x = texel_of(u, width, texture.wrap_u);
            const VI level_y = texel_of(v, std::max(1u, texture.height >> level), texture.wrap_v);
            const VI index = hn::Add(hn::Mul(level_y, hn::Set(si, std::int32_t(width))), level_x);
            const auto* first = surface.texels + scene::level_offset(texture, std::uint32_t(level));
            const VI texel = hn::GatherIndex(si, reinterpret_cast<const std::int32_t*>(first), index);
            const VF level_alpha = hn::ConvertTo(f, hn::BitCast(si, hn::ShiftRight<24>(hn::BitCast(ui, texel))));
            texture_alpha = hn::IfThenElse(here, level_alpha, texture_alpha);
            x = hn::IfThenElse(hn::RebindMask(si, here), level_x, x);
            y = hn::IfThenElse(hn::RebindMask(si, here), level_y, y);
        }
        alpha = hn::Mul(alpha, hn::Mul(texture_alpha, hn::Set(f, 1.0f / 255.0f)));
    } else {
        x = texel_of(b1, 64, scene::Wrap::clamp);
        y = texel_of(b2, 64, scene::Wrap::clamp);
    }
    const VF threshold = surface.is_blended ? threshold_of(surface.seed, x, y) : hn::Set(f, surface.cutoff);
    return hn::And(win, hn::Ge(alpha, threshold));
}

// Draws triangle i of the leaf into the pixels that it wins.
template <bool kAlpha>
HWY_INLINE void draw(const LeafScratch& s, int i, std::uint32_t instance, std::uint32_t triangle, Tile& tile,
                     AlphaDraw* alpha) {
    const VF a0 = hn::Set(f, s.a[0][i]), a1 = hn::Set(f, s.a[1][i]), a2 = hn::Set(f, s.a[2][i]);
    const VF b0 = hn::Set(f, s.b[0][i]), b1 = hn::Set(f, s.b[1][i]), b2 = hn::Set(f, s.b[2][i]);
    const VF c0 = hn::Set(f, s.c[0][i]), c1 = hn::Set(f, s.c[1][i]), c2 = hn::Set(f, s.c[2][i]);
    const VF gx = hn::Set(f, s.gx[i]), gy = hn::Set(f, s.gy[i]), g0 = hn::Set(f, s.g0[i]);
    const VF low = hn::Set(f, s.low[i]), high = hn::Set(f, s.high[i]);
    const auto own_instance = hn::Set(ui, instance), own_triangle = hn::Set(ui, triangle);
    const int first_chunk = s.x0[i] / kLanes * kLanes, last_chunk = s.x1[i];
    for (int row = s.y0[i]; row <= s.y1[i]; ++row) {
        const VF y = hn::Set(f, float(row) - kHalf);
        const VF r0 = hn::MulAdd(b0, y, c0), r1 = hn::MulAdd(b1, y, c1), r2 = hn::MulAdd(b2, y, c2);
        const VF rg = hn::MulAdd(gy, y, g0);
        for (int chunk = first_chunk; chunk <= last_chunk; chunk += kLanes) {
            const VF x = hn::Iota(f, float(chunk) - kHalf);
            const VF e[3] = {hn::MulAdd(a0, x, r0), hn::MulAdd(a1, x, r1), hn::MulAdd(a2, x, r2)};
            // Not-a-number (a sliver's plane) becomes `low`: x86's max returns its second operand then.
            const VF inverse_depth = hn::Min(hn::Max(hn::MulAdd(gx, x, rg), low), high);
            float* best_at = tile.best + row * 16 + chunk;
            const VF best = hn::Load(f, best_at);
            const MF inside = hn::Ge(min3(e[0], e[1], e[2]), hn::Zero(f));
            MF win = hn::And(inside, hn::Ge(inverse_depth, best));
            if (hn::AllFalse(f, win)) continue;
            std::uint32_t* instance_at = tile.instance + row * 16 + chunk;
            std::uint32_t* triangle_at = tile.triangle + row * 16 + chunk;
            const auto old_instance = hn::Load(ui, instance_at), old_triangle = hn::Load(ui, triangle_at);
            const MF tie = hn::And(win, hn::Eq(inverse_depth, best));
            if (HWY_UNLIKELY(!hn::AllFalse(f, tie))) {
                const auto smaller =
                    hn::Or(hn::Lt(own_instance, old_instance),
                           hn::And(hn::Eq(own_instance, old_instance), hn::Lt(own_triangle, old_triangle)));
                win = hn::AndNot(hn::AndNot(hn::RebindMask(f, smaller), tie), win);
            }
            if constexpr (kAlpha) {
                win = opaque_lanes(win, *alpha, s, i, e, inverse_depth);
                if (hn::AllFalse(f, win)) continue;
            }
            hn::Store(hn::IfThenElse(win, inverse_depth, best), f, best_at);
            const auto win_u = hn::RebindMask(ui, win);
            hn::Store(hn::IfThenElse(win_u, own_instance, old_instance), ui, instance_at);
            hn::Store(hn::IfThenElse(win_u, own_triangle, old_triangle), ui, triangle_at);
            tile.changed = true;
        }
    }
}

HWY_INLINE void find_farthest(Tile& tile) {
    tile.far[0] = 0.0f;
    for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
        const float* first = tile.best + (quarter / 2) * 128 + (quarter % 2) * 8;
        const hn::CappedTag<float, 8> eight;
        auto least = hn::Load(eight, first);
        for (int row = 0; row < 8; ++row) {
            for (int x = 0; x < 8; x += int(hn::MaxLanes(eight)))
                least = hn::Min(least, hn::Load(eight, first + row * 16 + x));
        }
        tile.quarter_best[quarter] = hn::GetLane(hn::MinOfLanes(eight, least));
        const float far = 1.000001f / tile.quarter_best[quarter];
        for (std::uint32_t set = 0; set < (1u << quarter); ++set)
            tile.far[set | (1u << quarter)] = std::max(tile.far[set], far);
    }
    tile.changed = false;
}

HWY_NOINLINE void draw_leaf(const scene::StaticScene& scene, const BvhLeaf& leaf, std::uint32_t instance,
                            const Linear (&xyw)[3], float pixel_angle, Tile& tile) {
    LeafScratch s;
    const bool projected = transform_vertices(leaf, xyw, s);
    std::uint32_t bits = 0;
    // Registers wider than a direct block would need it twice over: they look up.
    const bool direct = kLanes <= BvhLeaf::kMaxDirect && leaf.triangle_count <= BvhLeaf::kMaxDirect;
    for (int first = 0; first < leaf.triangle_count; first += kLanes) {
        bits |= projected
                    ? (direct ? set_up<true, true>(leaf, first, tile, s) : set_up<true, false>(leaf, first, tile, s))
                    : (direct ? set_up<false, true>(leaf, first, tile, s) : set_up<false, false>(leaf, first, tile, s));
    }
    for (; bits != 0; bits &= bits - 1) {
        const int i = std::countr_zero(bits);
        const std::uint32_t triangle = leaf.first_triangle + std::uint32_t(i);
        if (HWY_UNLIKELY((leaf.alpha_triangles >> i) & 1)) {
            AlphaDraw alpha{scene, instance, triangle, pixel_angle, false, {}};
            draw<true>(s, i, instance, triangle, tile, &alpha);
        } else {
            draw<false>(s, i, instance, triangle, tile, nullptr);
        }
    }
    if (tile.changed) find_farthest(tile);
}

// ---- A tile

HWY_INLINE Vec3 reach_of(const Vec3& low, const Vec3& high) {
    return glm::max(glm::abs(low), glm::abs(high));
}

// Pixels asked for, within the image; false when there are none.
HWY_INLINE bool begin_tile(const PinholeView& view, const TileRequest& request, std::uint16_t (&rows)[kTileSize],
                           Tile& tile) {
    const int columns = std::min(kTileSize, view.width - int(request.x));
    std::uint32_t any_column = 0, any_row = 0;
    for (int row = 0; row < kTileSize; ++row) {
        const bool in_image = columns > 0 && int(request.y) + row < view.height;
        rows[row] = in_image ? std::uint16_t(request.rows[row] & ((1u << columns) - 1u)) : std::uint16_t(0);
        any_column |= rows[row];
        if (rows[row] != 0) any_row |= 1u << row;
        for (int chunk = 0; chunk < kTileSize; chunk += kLanes) {
            const std::uint32_t bits = std::uint32_t(rows[row]) >> chunk;
            const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
            const MF asked = hn::LoadMaskBits(f, bytes);
            const int at = row * 16 + chunk;
            hn::Store(hn::IfThenElse(asked, hn::Zero(f), hn::Set(f, kInf)), f, tile.best + at);
            hn::Store(hn::Set(ui, kSkyInstance), ui, tile.instance + at);
            hn::Store(hn::Zero(ui), ui, tile.triangle + at);
        }
    }
    if (any_column == 0) return false;
    tile.first_column = float(std::countr_zero(any_column));
    tile.last_column = float(31 - std::countl_zero(any_column));
    tile.first_row = float(std::countr_zero(any_row));
    tile.last_row = float(31 - std::countl_zero(any_row));
    find_farthest(tile);
    return true;
}

HWY_INLINE void write_tile(const Tile& tile, const TileRequest& request, const std::uint16_t (&rows)[kTileSize],
                           VisibilityBuffer& out) {
    for (int row = 0; row < kTileSize; ++row) {
        if (rows[row] == 0) continue;
        for (int chunk = 0; chunk < kTileSize; chunk += kLanes) {
            const std::uint32_t bits = std::uint32_t(rows[row]) >> chunk;
            const int at = row * 16 + chunk;
            const std::size_t to = out.index(request.x + chunk, request.y + row);
            const VF depth = hn::Div(hn::Set(f, 1.0f), hn::Load(f, tile.best + at));
            const auto instance = hn::Load(ui, tile.instance + at), triangle = hn::Load(ui, tile.triangle + at);
            constexpr std::uint32_t kAll = (1u << kLanes) - 1u;
            if ((bits & kAll) == kAll) {
                hn::StoreU(depth, f, out.depth.data() + to);
                hn::StoreU(instance, ui, out.instance.data() + to);
                hn::StoreU(triangle, ui, out.triangle.data() + to);
            } else {  // masked stores are slow on some machines, but leave what others may be writing
                const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
                const MF asked = hn::LoadMaskBits(f, bytes);
                const auto asked_u = hn::RebindMask(ui, asked);
                hn::BlendedStore(depth, asked, f, out.depth.data() + to);
                hn::BlendedStore(instance, asked_u, ui, out.instance.data() + to);
                hn::BlendedStore(triangle, asked_u, ui, out.triangle.data() + to);
            }
        }
    }
}

}  // namespace

void CastTile(const scene::StaticScene& scene, const BeamView& view, const TileRequest& request, VisibilityBuffer& out,
              CastCost& cost) {
    Tile tile;
    std::uint16_t rows[kTileSize];
    if (!begin_tile(view.view, request, rows, tile)) return;
    for (const std::uint16_t row : rows) cost.rays += std::uint64_t(std::popcount(row));

    const DMat3 tile_from_world = view.tile_from_world(request.x, request.y);
    const auto linears = [&](Linear(&xyw)[3], const DMat3& world_from_space, const WorldPos& origin) {
        const DVec3 offset = origin - view.view.position;
        for (int row = 0; row < 3; ++row) xyw[row] = linear_of(tile_from_world, row, world_from_space, offset);
    };
    const auto draw_instance = [&](std::uint32_t id) {
        const scene::Instance& instance = scene.instances[id];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        const BvhNode* nodes = scene.mesh_nodes.data() + mesh.first_node;
        const BvhLeaf* leaves = scene.mesh_leaves.data() + mesh.first_leaf;
        Linear xyw[3];
        linears(xyw, DMat3(instance.world_from_mesh), instance.position);
        const Beam beam = make_beam(xyw, reach_of(mesh.bounds.low, mesh.bounds.high), tile);
        walk(
            nodes, beam, tile, cost.nodes,
            [&](std::uint32_t child) {
                if (child & kBvhLeafBit)
                    prefetch(leaves + (child & ~kBvhLeafBit));
                else
                    prefetch(nodes + child);
            },
            [&](std::uint32_t leaf) {
                cost.triangles += leaves[leaf].triangle_count;
                draw_leaf(scene, leaves[leaf], id, xyw, view.pixel_angle, tile);
            });
    };
    if (!scene.instance_nodes.empty()) {
        Linear xyw[3];
        linears(xyw, DMat3(1.0), scene.origin);
        const Vec3 reach = reach_of(Vec3(scene.bounds.low - scene.origin), Vec3(scene.bounds.high - scene.origin));
        const Beam beam = make_beam(xyw, reach, tile);
        walk(
            scene.instance_nodes.data(), beam, tile, cost.nodes, [](std::uint32_t) {}, draw_instance);
    }
    write_tile(tile, request, rows, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::beam {
HWY_EXPORT(CastTile);

void cast_tile(const scene::StaticScene& scene, const BeamView& view, const TileRequest& request, VisibilityBuffer& out,
               CastCost& cost) {
    HWY_DYNAMIC_DISPATCH(CastTile)(scene, view, request, out, cost);
}
}  // namespace ff::farfield::beam
#endif
