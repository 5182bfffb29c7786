// Triangles of a leaf against the points of a group, in light space. Compiled once per SIMD target; include after
// <hwy/highway.h>.
//
// No light leaks: many points are asked by edge functions that are widened by their own rounding error; few points by
// products of vertices relative to the point (Woop et al. 2013), whose signs are opposite in the two triangles that
// share an edge, and zero counts as inside.
#if defined(FF_SUN_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SUN_LEAF_INL_H_
#undef FF_SUN_LEAF_INL_H_
#else
#define FF_SUN_LEAF_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/beam_setup-inl.h"
#include "engine/farfield/sun_space-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

constexpr int kFewForLeaf = 8;  // points that are asked one by one, eight triangles at a time

// A leaf's triangles in light space.
struct alignas(64) LightLeaf {
    float s[32], t[32], d[32];
    float s0[16], t0[16];                // corner 0, to which what follows is relative
    float a[3][16], b[3][16], c[3][16];  // edge functions a s + b t + c, inside positive
    float gs[16], gt[16], g0[16];        // d as a plane
    float low[16], high[16];             // its range over the triangle
};

// A leaf, and what has to be known to test it.
struct LeafQuestion {
    const scene::StaticScene& scene;
    const BvhLeaf& leaf;
    std::uint32_t instance;  // in the scene
    std::uint32_t name;      // as points name it
    const GroupPoints& points;
};

HWY_INLINE void light_vertices(const BvhLeaf& leaf, const LightRows& rows, LightLeaf& out) {
    for (int v = 0; v < leaf.vertex_count; v += kLanes) {
        const VF x = hn::Load(f, leaf.x + v), y = hn::Load(f, leaf.y + v), z = hn::Load(f, leaf.z + v);
        const auto apply = [&](const Linear& l) {
            return hn::MulAdd(hn::Set(f, l.x), x,
                              hn::MulAdd(hn::Set(f, l.y), y, hn::MulAdd(hn::Set(f, l.z), z, hn::Set(f, l.c))));
        };
        hn::Store(apply(rows.s), f, out.s + v);
        hn::Store(apply(rows.t), f, out.t + v);
        hn::Store(apply(rows.d), f, out.d + v);
    }
}

// Corner k of kLanes triangles from `first` on.
struct LightCorner {
    VF s, t, d;
};
HWY_INLINE LightCorner light_corner(const BvhLeaf& leaf, const LightLeaf& l, int first, int k) {
    if (kLanes <= BvhLeaf::kMaxDirect && leaf.triangle_count <= BvhLeaf::kMaxDirect) {
        const int at = k * BvhLeaf::kMaxDirect + first;
        return {hn::Load(f, l.s + at), hn::Load(f, l.t + at), hn::Load(f, l.d + at)};
    }
    const hn::Rebind<std::uint8_t, I> bytes;
    const VI index = hn::PromoteTo(si, hn::LoadU(bytes, leaf.corner[k] + first));
    const int count = leaf.vertex_count;
    return {lookup(l.s, index, count), lookup(l.t, index, count), lookup(l.d, index, count)};
}

HWY_INLINE MF lanes_of(const BvhLeaf& leaf, int first) {
    return hn::RebindMask(f, hn::Lt(hn::Iota(si, first), hn::Set(si, leaf.triangle_count)));
}

// Whether triangle i, which the point's ray meets at these barycentrics, hides the sun from it.
HWY_INLINE bool hides(const LeafQuestion& q, std::uint32_t triangle, int point, const AlphaSurface* surface, float b1,
                      float b2) {
    const PointGroup& group = q.points.group;
    if (group.own_instance[point] == q.name && group.own_triangle[point] == triangle) return false;
    return surface == nullptr || is_opaque_at(*surface, b1, b2, group.footprint[point]);
}

// Points that the leaf hides, for few of them.
HWY_INLINE std::uint64_t hidden_one_by_one(const LeafQuestion& q, const LightLeaf& l, std::uint64_t points) {
    const BvhLeaf& leaf = q.leaf;
    std::uint64_t hidden = 0;
    for (int first = 0; first < leaf.triangle_count; first += kLanes) {
        LightCorner p[3];
        for (int k = 0; k < 3; ++k) p[k] = light_corner(leaf, l, first, k);
        const MF valid = lanes_of(leaf, first);
        for (std::uint64_t rest = points & ~hidden; rest != 0; rest &= rest - 1) {
            const int point = std::countr_zero(rest);
            const VF s = hn::Set(f, q.points.group.s[point]), t = hn::Set(f, q.points.group.t[point]);
            const VF d = hn::Set(f, q.points.group.d[point]);
            const VF as = hn::Sub(p[0].s, s), at = hn::Sub(p[0].t, t), bs = hn::Sub(p[1].s, s);
            const VF bt = hn::Sub(p[1].t, t), cs = hn::Sub(p[2].s, s), ct = hn::Sub(p[2].t, t);
            const VF u = hn::Sub(hn::Mul(cs, bt), hn::Mul(ct, bs));
            const VF v = hn::Sub(hn::Mul(as, ct), hn::Mul(at, cs));
            const VF w = hn::Sub(hn::Mul(bs, at), hn::Mul(bt, as));
            const VF least = min3(u, v, w), most = max3(u, v, w), zero = hn::Zero(f);
            const VF det = hn::Add(u, hn::Add(v, w));
            MF met = hn::And(valid, hn::Or(hn::Ge(least, zero), hn::Le(most, zero)));
            met = hn::And(met, hn::Ne(det, zero));
            // Above the point: the weighted distances have the determinant's sign.
            const VF above =
                hn::MulAdd(u, hn::Sub(p[0].d, d), hn::MulAdd(v, hn::Sub(p[1].d, d), hn::Mul(w, hn::Sub(p[2].d, d))));
            met = hn::And(met, hn::Gt(hn::Xor(above, hn::And(det, hn::Set(f, -0.0f))), zero));
            std::uint32_t bits = bits_of(met);
            if (bits == 0) continue;
            alignas(64) float vs[16], ws[16], dets[16];
            hn::Store(v, f, vs);
            hn::Store(w, f, ws);
            hn::Store(det, f, dets);
            for (; bits != 0; bits &= bits - 1) {
                const int lane = std::countr_zero(bits), i = first + lane;
                const std::uint32_t triangle = leaf.first_triangle + std::uint32_t(i);
                bool is_hidden;
                if ((leaf.alpha_triangles >> i) & 1) {
                    const AlphaSurface surface =
                        make_alpha_surface(q.scene, q.scene.instances[q.instance], q.instance, triangle);
                    is_hidden = hides(q, triangle, point, &surface, vs[lane] / dets[lane], ws[lane] / dets[lane]);
                } else {
                    is_hidden = hides(q, triangle, point, nullptr, 0, 0);
                }
                if (!is_hidden) continue;
                hidden |= std::uint64_t(1) << point;
                break;
            }
        }
    }
    return hidden;
}

// Bounds of some points.
struct PointBounds {
    float least_s, most_s, least_t, most_t, least_d;
};
// By eights.
HWY_INLINE PointBounds bounds_of(const GroupPoints& p, std::uint64_t points) {
    const std::uint32_t eights = eights_of_points(points);
    PointBounds out{kInf, -kInf, kInf, -kInf, kInf};
    for (int i = 0; i < kEights; i += kPointLanes) {
        const std::uint8_t bytes[8] = {std::uint8_t(eights >> i)};
        const MP in = hn::LoadMaskBits(pf, bytes);
        const auto least = [&](const EightBounds& b) {
            return hn::GetLane(hn::MinOfLanes(pf, hn::IfThenElse(in, hn::Load(pf, b.least + i), hn::Set(pf, kInf))));
        };
        const auto most = [&](const EightBounds& b) {
            return hn::GetLane(hn::MaxOfLanes(pf, hn::IfThenElse(in, hn::Load(pf, b.most + i), hn::Set(pf, -kInf))));
        };
        out = {std::min(out.least_s, least(p.s)), std::max(out.most_s, most(p.s)), std::min(out.least_t, least(p.t)),
               std::max(out.most_t, most(p.t)), std::min(out.least_d, least(p.d))};
    }
    return out;
}

// Sets up kLanes triangles from `first` on; returns those that may hide a point within the bounds, as bits.
HWY_INLINE std::uint32_t set_up_light(const BvhLeaf& leaf, int first, const PointBounds& bounds, LightLeaf& l) {
    LightCorner p[3];
    for (int k = 0; k < 3; ++k) p[k] = light_corner(leaf, l, first, k);
    const VF high = max3(p[0].d, p[1].d, p[2].d), low = min3(p[0].d, p[1].d, p[2].d);
    const VF low_s = min3(p[0].s, p[1].s, p[2].s), high_s = max3(p[0].s, p[1].s, p[2].s);
    const VF low_t = min3(p[0].t, p[1].t, p[2].t), high_t = max3(p[0].t, p[1].t, p[2].t);
    const VF ab_s = hn::Sub(p[1].s, p[0].s), ab_t = hn::Sub(p[1].t, p[0].t);
    const VF ac_s = hn::Sub(p[2].s, p[0].s), ac_t = hn::Sub(p[2].t, p[0].t);
    const VF size = hn::Max(hn::Max(hn::Abs(ab_s), hn::Abs(ab_t)), hn::Max(hn::Abs(ac_s), hn::Abs(ac_t)));
    const VF margin = hn::Mul(size, hn::Set(f, 4.0f * kEdgeError));  // more than what edges are widened by
    MF alive = hn::And(lanes_of(leaf, first), hn::Gt(high, hn::Set(f, bounds.least_d)));
    alive = hn::And(alive, hn::And(hn::Le(hn::Sub(low_s, margin), hn::Set(f, bounds.most_s)),
                                   hn::Ge(hn::Add(high_s, margin), hn::Set(f, bounds.least_s))));
    alive = hn::And(alive, hn::And(hn::Le(hn::Sub(low_t, margin), hn::Set(f, bounds.most_t)),
                                   hn::Ge(hn::Add(high_t, margin), hn::Set(f, bounds.least_t))));
    if (hn::AllFalse(f, alive)) return 0;

    // Relative to corner 0, so that small triangles far from the group's centre keep their shape. Edge k lies opposite
    // of corner k; those at corner 0 have no constant but their widening.
    const VF area = hn::Sub(hn::Mul(ab_s, ac_t), hn::Mul(ab_t, ac_s));
    const VF sign = hn::And(area, hn::Set(f, -0.0f));
    VF a[3] = {hn::Sub(ab_t, ac_t), ac_t, hn::Neg(ab_t)}, b[3] = {hn::Sub(ac_s, ab_s), hn::Neg(ac_s), ab_s};
    VF c[3] = {hn::Abs(area), hn::Zero(f), hn::Zero(f)}, rounding = hn::Zero(f);
    for (int k = 0; k < 3; ++k) {
        // All terms are products of two lengths within the triangle.
        const VF error = hn::Mul(hn::Mul(hn::Add(hn::Abs(a[k]), hn::Abs(b[k])), size), hn::Set(f, kEdgeError));
        rounding = hn::Max(rounding, error);
        a[k] = hn::Xor(a[k], sign);
        b[k] = hn::Xor(b[k], sign);
        c[k] = hn::Add(c[k], error);
    }
    // A triangle seen edge-on, no wider than the rounding of its edges, covers nothing that its neighbours' widened
    // edges do not.
    alive = hn::And(alive, hn::Gt(hn::Abs(area), rounding));
    const std::uint32_t bits = bits_of(alive);
    if (bits == 0) return 0;

    const VF inverse_area = hn::Div(hn::Set(f, 1.0f), area);
    const VF ab = hn::Sub(p[1].d, p[0].d), ac = hn::Sub(p[2].d, p[0].d);
    const VF gs = hn::Mul(hn::Sub(hn::Mul(ab, ac_t), hn::Mul(ac, ab_t)), inverse_area);
    const VF gt = hn::Mul(hn::Sub(hn::Mul(ac, ab_s), hn::Mul(ab, ac_s)), inverse_area);
    for (int k = 0; k < 3; ++k) {
        hn::Store(a[k], f, l.a[k] + first);
        hn::Store(b[k], f, l.b[k] + first);
        hn::Store(c[k], f, l.c[k] + first);
    }
    hn::Store(gs, f, l.gs + first);
    hn::Store(gt, f, l.gt + first);
    hn::Store(p[0].s, f, l.s0 + first);
    hn::Store(p[0].t, f, l.t0 + first);
    hn::Store(p[0].d, f, l.g0 + first);
    hn::Store(low, f, l.low + first);
    hn::Store(high, f, l.high + first);
    return bits << first;
}

// Eights of points that triangle i may hide some of: the corner of their bounds where an edge function is greatest is
// asked, with the very operations of the points, which are monotonic.
HWY_INLINE std::uint32_t eights_under(const LightLeaf& l, int i, const GroupPoints& p) {
    std::uint32_t eights = 0;
    for (int at = 0; at < kEights; at += kPointLanes) {
        MP under = hn::Lt(hn::Load(pf, p.d.least + at), hn::Set(pf, l.high[i]));
        for (int k = 0; k < 3; ++k) {
            const float a = l.a[k][i], b = l.b[k][i];
            const VP s = hn::Sub(hn::Load(pf, (a > 0.0f ? p.s.most : p.s.least) + at), hn::Set(pf, l.s0[i]));
            const VP t = hn::Sub(hn::Load(pf, (b > 0.0f ? p.t.most : p.t.least) + at), hn::Set(pf, l.t0[i]));
            const VP most = hn::MulAdd(hn::Set(pf, a), s, hn::MulAdd(hn::Set(pf, b), t, hn::Set(pf, l.c[k][i])));
            under = hn::And(under, hn::Ge(most, hn::Zero(pf)));
        }
        eights |= point_bits(under) << at;
    }
    return eights;
}

// Points that triangle i hides.
HWY_INLINE std::uint64_t hidden_by_triangle(const LeafQuestion& q, const LightLeaf& l, int i, std::uint64_t points) {
    std::uint32_t eights = eights_of_points(points) & eights_under(l, i, q.points);
    if (eights == 0) return 0;
    const PointGroup& p = q.points.group;
    VP a[3], b[3], c[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = hn::Set(pf, l.a[k][i]);
        b[k] = hn::Set(pf, l.b[k][i]);
        c[k] = hn::Set(pf, l.c[k][i]);
    }
    const VP s0 = hn::Set(pf, l.s0[i]), t0 = hn::Set(pf, l.t0[i]);
    const VP gs = hn::Set(pf, l.gs[i]), gt = hn::Set(pf, l.gt[i]), g0 = hn::Set(pf, l.g0[i]);
    const VP low = hn::Set(pf, l.low[i]), high = hn::Set(pf, l.high[i]);
    const std::uint32_t triangle = q.leaf.first_triangle + std::uint32_t(i);
    const bool is_see_through = ((q.leaf.alpha_triangles >> i) & 1) != 0;
    AlphaSurface surface;
    bool has_surface = false;
    std::uint64_t hidden = 0;
    for (; eights != 0; eights &= eights - 1) {
        const int first = std::countr_zero(eights) * 8;
        for (int at = first; at < first + 8; at += kPointLanes) {
            const VP s = hn::Sub(hn::Load(pf, p.s + at), s0), t = hn::Sub(hn::Load(pf, p.t + at), t0);
            VP e[3];
            for (int k = 0; k < 3; ++k) e[k] = hn::MulAdd(a[k], s, hn::MulAdd(b[k], t, c[k]));
            // Not-a-number (a sliver's plane) becomes `low`: x86's max returns its second operand then.
            const VP d = hn::Min(hn::Max(hn::MulAdd(gs, s, hn::MulAdd(gt, t, g0)), low), high);
            const VP inside = hn::Min(e[0], hn::Min(e[1], e[2]));
            MP met = hn::And(hn::Ge(inside, hn::Zero(pf)), hn::Gt(d, hn::Load(pf, p.d + at)));
            if (hn::AllFalse(pf, met)) continue;
            const hn::RebindToUnsigned<P> pu;
            const auto is_own = hn::And(hn::Eq(hn::Load(pu, p.own_instance + at), hn::Set(pu, q.name)),
                                        hn::Eq(hn::Load(pu, p.own_triangle + at), hn::Set(pu, triangle)));
            met = hn::AndNot(hn::RebindMask(pf, is_own), met);
            std::uint32_t bits = point_bits(met) & std::uint32_t(points >> at) & ((1u << kPointLanes) - 1u);
            if (HWY_UNLIKELY(is_see_through) && bits != 0) {
                if (!has_surface)
                    surface = make_alpha_surface(q.scene, q.scene.instances[q.instance], q.instance, triangle);
                has_surface = true;
                const VP per_sum = hn::Div(hn::Set(pf, 1.0f), hn::Add(e[0], hn::Add(e[1], e[2])));
                alignas(32) float b1[8], b2[8];
                hn::Store(hn::Mul(e[1], per_sum), pf, b1);
                hn::Store(hn::Mul(e[2], per_sum), pf, b2);
                for (std::uint32_t rest = bits; rest != 0; rest &= rest - 1) {
                    const int lane = std::countr_zero(rest);
                    if (!is_opaque_at(surface, b1[lane], b2[lane], p.footprint[at + lane])) bits &= ~(1u << lane);
                }
            }
            hidden |= std::uint64_t(bits) << at;
        }
    }
    return hidden;
}

// Points that the leaf hides.
HWY_NOINLINE std::uint64_t hidden_by_leaf(const LeafQuestion& q, const LightRows& rows, std::uint64_t points) {
    LightLeaf l;
    light_vertices(q.leaf, rows, l);
    if (std::popcount(points) <= kFewForLeaf) return hidden_one_by_one(q, l, points);
    const PointBounds bounds = bounds_of(q.points, points);
    std::uint32_t triangles = 0;
    for (int first = 0; first < q.leaf.triangle_count; first += kLanes)
        triangles |= set_up_light(q.leaf, first, bounds, l);
    std::uint64_t hidden = 0;
    for (; triangles != 0 && hidden != points; triangles &= triangles - 1)
        hidden |= hidden_by_triangle(q, l, std::countr_zero(triangles), points & ~hidden);
    return hidden;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
