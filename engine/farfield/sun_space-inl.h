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
using sun::Occluders;
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
    float point_s[3], point_t[3];  // component of a point: point_s s + point_t t; what is constant is in the boxes
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
        const float constant = s[k] * rows.t.c - t[k] * rows.s.c;
        space.low[k] = {u, v, constant - error, side(u, false, i), side(v, false, j)};
        space.high[k] = {u, v, constant + error, side(u, true, i), side(v, true, j)};
        space.point_s[k] = -t[k];
        space.point_t[k] = s[k];
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

// Points come in eights, whatever the registers: a set of eight is a byte of a set of all.
using P = hn::CappedTag<float, 8>;
using VP = hn::Vec<P>;
using MP = hn::Mask<P>;
constexpr P pf;
constexpr int kPointLanes = int(hn::MaxLanes(pf));
constexpr int kEights = PointGroup::kMost / 8;

HWY_INLINE std::uint32_t point_bits(MP mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(pf, mask, bytes);
    return bytes[0];
}

// Bits of all points of these eights.
HWY_INLINE std::uint64_t points_of_eights(std::uint32_t eights) {
    const std::uint64_t bit_of_each = std::uint64_t(eights) * 0x0101010101010101u & 0x8040201008040201u;
    return ((bit_of_each + 0x7F7F7F7F7F7F7F7Fu) >> 7 & 0x0101010101010101u) * 0xFFu;
}
// Eights of which some point is in the set.
HWY_INLINE std::uint32_t eights_of_points(std::uint64_t points) {
    points |= points >> 4;
    points |= points >> 2;
    points |= points >> 1;
    return std::uint32_t((points & 0x0101010101010101u) * 0x0102040810204080u >> 56);
}

// Least and greatest of each eight points.
struct EightBounds {
    alignas(32) float least[kEights], most[kEights];
};

// A group's points. What its eights are bounded by is found without moving lanes from the same points turned: the j-th
// of each eight beside each other.
struct GroupPoints {
    explicit HWY_INLINE GroupPoints(const PointGroup& points);

    const PointGroup& group;
    alignas(64) float turned_s[PointGroup::kMost], turned_t[PointGroup::kMost];
    EightBounds s, t, d;
    float least_d, most_d;
    float extent;  // largest absolute s or t
};

// @param value  of the j-th turned points
template <class Value>
HWY_INLINE void bound_eights(Value&& value, EightBounds& out, float& least, float& most) {
    float low_of_all = kInf, high_of_all = -kInf;
    for (int i = 0; i < kEights; i += kPointLanes) {
        VP low = value(i), high = low;
        for (int j = 1; j < 8; ++j) {
            const VP v = value(8 * j + i);
            low = hn::Min(low, v);
            high = hn::Max(high, v);
        }
        hn::Store(low, pf, out.least + i);
        hn::Store(high, pf, out.most + i);
        low_of_all = std::min(low_of_all, hn::GetLane(hn::MinOfLanes(pf, low)));
        high_of_all = std::max(high_of_all, hn::GetLane(hn::MaxOfLanes(pf, high)));
    }
    least = low_of_all;
    most = high_of_all;
}

HWY_INLINE GroupPoints::GroupPoints(const PointGroup& points) : group(points) {
    alignas(64) float turned_d[PointGroup::kMost];
    for (int i = 0; i < PointGroup::kMost; ++i) {
        const int from = i % 8 * 8 + i / 8;
        turned_s[i] = group.s[from];
        turned_t[i] = group.t[from];
        turned_d[i] = group.d[from];
    }
    const auto load = [](const float* values) { return [values](int i) { return hn::Load(pf, values + i); }; };
    float low_s, high_s, low_t, high_t;
    bound_eights(load(turned_s), s, low_s, high_s);
    bound_eights(load(turned_t), t, low_t, high_t);
    bound_eights(load(turned_d), d, least_d, most_d);
    extent = std::max(std::max(-low_s, high_s), std::max(-low_t, high_t));
}

// The points in a hierarchy's slabs: the same for all that are turned and scaled alike, wherever they stand.
struct Slabs {
    alignas(64) float at[3][PointGroup::kMost];
    EightBounds eights[3];
    float least[3], most[3];
};

HWY_INLINE void find_slabs(const SunSpace& space, const GroupPoints& p, Slabs& out) {
    for (int k = 0; k < 3; ++k) {
        const VP of_s = hn::Set(pf, space.point_s[k]), of_t = hn::Set(pf, space.point_t[k]);
        const auto value = [&](const float* s, const float* t, int i) {
            return hn::MulAdd(of_s, hn::Load(pf, s + i), hn::Mul(of_t, hn::Load(pf, t + i)));
        };
        for (int i = 0; i < p.group.count; i += kPointLanes)
            hn::Store(value(p.group.s, p.group.t, i), pf, out.at[k] + i);
        bound_eights([&](int i) { return value(p.turned_s, p.turned_t, i); }, out.eights[k], out.least[k], out.most[k]);
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
