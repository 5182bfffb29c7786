// Boxes and points of one hierarchy as sun rays see them. Compiled once per SIMD target; include after
// <hwy/highway.h>.
//
// A hierarchy's vertices x come into light space by three linear functions: s = S.x + cs, t = T.x + ct, d = D.x + cd.
// A ray is what has one (s, t). The vector x x (S x T) = S (T.x) - T (S.x) is the same all along a ray, so that each of
// its components is a slab in which a box is an interval, of two of its sides' products, and a ray a number: the three
// slabs are the hexagon that is the box's shadow, whatever way the hierarchy is turned. With the box's greatest d that
// is a test without division, exact but for the far end of the ray.
#if defined(FF_SUN_SPACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SUN_SPACE_INL_H_
#undef FF_SUN_SPACE_INL_H_
#else
#define FF_SUN_SPACE_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/farfield/beam_tile-inl.h"
#include "engine/farfield/sun_group.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

using sun::LightFrame;
using sun::PointGroup;

// Light space, relative to a group's centre, from a hierarchy's own.
struct LightRows {
    Linear s, t, d;
};

HWY_INLINE LightRows light_rows(const LightFrame& light, const Mat3& world_from_space, const DVec3& offset) {
    const DVec3 x(world_from_space[0]), y(world_from_space[1]), z(world_from_space[2]);
    const auto row = [&](const DVec3& axis) {
        return Linear{float(glm::dot(axis, x)), float(glm::dot(axis, y)), float(glm::dot(axis, z)),
                      float(glm::dot(axis, offset))};
    };
    return {row(light.s), row(light.t), row(light.d)};
}

// What a node's boxes are asked: least and greatest component of each slab, greatest d. `row` says which of a node's
// six rows (low x y z, high x y z) holds the coordinate.
struct BoxFunction {
    float u, v, c;
    std::uint32_t row_u, row_v;
};
struct SunSpace {
    BoxFunction low[3], high[3];
    Linear d;
    std::uint32_t row_x, row_y, row_z;
    float point_s[3], point_t[3], point_c[3];  // component of a point: point_s s + point_t t + point_c
};

// @param reach   largest absolute coordinate of the hierarchy's boxes
// @param extent  largest absolute s or t of the points
HWY_INLINE SunSpace sun_space(const LightRows& rows, const Vec3& reach, float extent) {
    SunSpace space;
    const float s[3] = {rows.s.x, rows.s.y, rows.s.z}, t[3] = {rows.t.x, rows.t.y, rows.t.z};
    float along[3], terms[3];  // S x T, and what its components are differences of
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        along[k] = s[i] * t[j] - t[i] * s[j];
        terms[k] = std::abs(s[i] * t[j]) + std::abs(t[i] * s[j]);
    }
    const auto side = [](float slope, bool upper, int axis) {
        return std::uint32_t(((slope > 0.0f) == upper ? 3 : 0) + axis) * 16;
    };
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        // Component k of x x along: x[i] along[j] - x[j] along[i].
        const float u = along[j], v = -along[i];
        const float error =
            kBoxError * (terms[j] * reach[i] + terms[i] * reach[j] + std::abs(s[k]) * (std::abs(rows.t.c) + extent) +
                         std::abs(t[k]) * (std::abs(rows.s.c) + extent));
        space.low[k] = {u, v, -error, side(u, false, i), side(v, false, j)};
        space.high[k] = {u, v, error, side(u, true, i), side(v, true, j)};
        space.point_s[k] = -t[k];
        space.point_t[k] = s[k];
        space.point_c[k] = t[k] * rows.s.c - s[k] * rows.t.c;
    }
    space.d = rows.d;
    space.d.c += kBoxError * (std::abs(rows.d.x) * reach.x + std::abs(rows.d.y) * reach.y +
                              std::abs(rows.d.z) * reach.z + std::abs(rows.d.c));
    space.row_x = side(rows.d.x, true, 0), space.row_y = side(rows.d.y, true, 1), space.row_z = side(rows.d.z, true, 2);
    return space;
}

// A node's boxes in the slabs.
struct alignas(64) BoxSlabs {
    float low[3][16], high[3][16], far[16];
};

HWY_INLINE VF box_value(const BoxFunction& function, const float* lanes) {
    const VF v = hn::MulAdd(hn::Set(f, function.v), hn::Load(f, lanes + function.row_v), hn::Set(f, function.c));
    return hn::MulAdd(hn::Set(f, function.u), hn::Load(f, lanes + function.row_u), v);
}
HWY_INLINE VF far_value(const SunSpace& space, const float* lanes) {
    const VF z = hn::MulAdd(hn::Set(f, space.d.z), hn::Load(f, lanes + space.row_z), hn::Set(f, space.d.c));
    const VF y = hn::MulAdd(hn::Set(f, space.d.y), hn::Load(f, lanes + space.row_y), z);
    return hn::MulAdd(hn::Set(f, space.d.x), hn::Load(f, lanes + space.row_x), y);
}

// Points of a group in a hierarchy's slabs, packed; filled up to whole registers by the last.
struct SlabPoints {
    int count = 0;
    alignas(64) float s[64], t[64], d[64];
    alignas(64) float slab[3][64];
    std::uint8_t of_group[64];
    // Bounds of all.
    float least_s, most_s, least_t, most_t, least_d, most_d;
    float least[3], most[3];
};

// Least and greatest of the first `count` numbers, filled up to whole registers.
HWY_INLINE void range_of(const float* values, int count, float& least, float& most) {
    VF low = hn::Load(f, values), high = low;
    for (int i = kLanes; i < count; i += kLanes) {
        const VF v = hn::Load(f, values + i);
        low = hn::Min(low, v);
        high = hn::Max(high, v);
    }
    least = hn::GetLane(hn::MinOfLanes(f, low));
    most = hn::GetLane(hn::MaxOfLanes(f, high));
}

// The points of `which`, of another packing of the group.
HWY_INLINE void pack_points(const float* s, const float* t, const float* d, const std::uint8_t* of_group,
                            std::uint64_t which, SlabPoints& out) {
    int n = 0;
    for (; which != 0; which &= which - 1, ++n) {
        const int i = std::countr_zero(which);
        out.s[n] = s[i], out.t[n] = t[i], out.d[n] = d[i];
        out.of_group[n] = of_group != nullptr ? of_group[i] : std::uint8_t(i);
    }
    out.count = n;
    for (; n % kLanes != 0; ++n) out.s[n] = out.s[n - 1], out.t[n] = out.t[n - 1], out.d[n] = out.d[n - 1];
    range_of(out.s, out.count, out.least_s, out.most_s);
    range_of(out.t, out.count, out.least_t, out.most_t);
    range_of(out.d, out.count, out.least_d, out.most_d);
}

HWY_INLINE float extent_of(const SlabPoints& p) {
    return std::max(std::max(-p.least_s, p.most_s), std::max(-p.least_t, p.most_t));
}

HWY_INLINE void find_slabs(const SunSpace& space, SlabPoints& p) {
    for (int k = 0; k < 3; ++k) {
        const VF of_s = hn::Set(f, space.point_s[k]), of_t = hn::Set(f, space.point_t[k]);
        const VF c = hn::Set(f, space.point_c[k]);
        for (int i = 0; i < p.count; i += kLanes)
            hn::Store(hn::MulAdd(of_s, hn::Load(f, p.s + i), hn::MulAdd(of_t, hn::Load(f, p.t + i), c)), f,
                      p.slab[k] + i);
        range_of(p.slab[k], p.count, p.least[k], p.most[k]);
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
