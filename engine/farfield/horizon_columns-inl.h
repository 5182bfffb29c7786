// What the two walks of horizon tracing share, compiled once per SIMD target: which columns a box is seen in, and how
// high it reaches there. Include after <hwy/highway.h>; no include guard in the usual sense, see Highway's manual.
#if defined(FF_HORIZON_COLUMNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_HORIZON_COLUMNS_INL_H_
#undef FF_HORIZON_COLUMNS_INL_H_
#else
#define FF_HORIZON_COLUMNS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "engine/farfield/horizon_azimuth.h"
#include "engine/farfield/horizon_trace.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::VFromD<D>;
constexpr D d;
constexpr DI di;

/// What a box with an upright footprint may add to the columns it is seen in: in column c, where it rises above the
/// eye,
///   rise * min(max_x[c] * a, max_z[c] * b, 1 / near), a and b being 1 / gap along x and z,
/// else rise * max(min_x[c] * a, min_z[c] * b) with a and b 1 / farthest.
struct Bound {
    float rise, a, b;
    int first, count;  ///< columns; none where there is nothing, rise being -inf
};

/// Footprints relative to the eye.
struct Extent {
    V low_x, low_z, high_x, high_z;
    V gap_x, gap_z;  ///< 0 where the eye is within
};

HWY_INLINE V azimuth_turn_v(V x, V z) {
    const V ax = hn::Abs(x), az = hn::Abs(z);
    const V t = hn::Div(hn::Min(ax, az), hn::Max(hn::Max(ax, az), hn::Set(d, 1e-37f)));
    V turn =
        hn::Mul(t, hn::Add(hn::Set(d, 0.125f), hn::Mul(hn::Set(d, kQuasiAngleBend), hn::Sub(hn::Set(d, 1.0f), t))));
    turn = hn::IfThenElse(hn::Gt(ax, az), hn::Sub(hn::Set(d, 0.25f), turn), turn);
    turn = hn::IfThenElse(hn::Gt(z, hn::Zero(d)), hn::Sub(hn::Set(d, 0.5f), turn), turn);
    return hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, 1.0f), turn), turn);
}

/// Computes the first column and the number of columns of a vector of boxes.
HWY_INLINE void compute_columns(const HorizonWedges& wedges, float margin_scale, const Extent& e,
                                std::int32_t* first_out, std::int32_t* count_out) {
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), columns = hn::Set(d, float(wedges.columns));
    const V margin = hn::Set(d, wedges.column_margin * margin_scale);
    // The two corners of the silhouette, clockwise, from which of the nine regions around it the eye looks.
    const auto east = hn::Gt(e.low_x, zero), west = hn::Lt(e.high_x, zero);
    const auto south = hn::Gt(e.low_z, zero), north = hn::Lt(e.high_z, zero);
    const auto between_x = hn::Not(hn::Or(east, west)), between_z = hn::Not(hn::Or(north, south));
    const auto level_east = hn::And(between_z, east);
    const V start_x = hn::IfThenElse(hn::Or(north, level_east), e.low_x, e.high_x);
    const V start_z = hn::IfThenElse(hn::Or(east, hn::And(between_x, south)), e.low_z, e.high_z);
    const V end_x = hn::IfThenElse(hn::Or(south, level_east), e.low_x, e.high_x);
    const V end_z = hn::IfThenElse(hn::Or(east, hn::And(between_x, north)), e.high_z, e.low_z);

    const V start = hn::Floor(hn::Sub(hn::Mul(azimuth_turn_v(start_x, start_z), columns), margin));
    const V end = hn::Floor(hn::Add(hn::Mul(azimuth_turn_v(end_x, end_z), columns), margin));
    V count = hn::Add(hn::Sub(end, start), one);
    count = hn::IfThenElse(hn::Le(count, zero), hn::Add(count, columns), count);
    // With the eye in the square (or as near as rounding can tell) it is all around.
    const auto inside = hn::And(hn::Eq(e.gap_x, zero), hn::Eq(e.gap_z, zero));
    count = hn::IfThenElse(inside, columns, hn::Min(count, columns));
    V first = hn::IfThenElse(hn::Lt(start, zero), hn::Add(start, columns), start);
    first = hn::IfThenElse(hn::Or(inside, hn::Ge(first, columns)), zero, first);
    hn::Store(hn::ConvertTo(di, first), di, first_out);
    hn::Store(hn::ConvertTo(di, count), di, count_out);
}

/// A bound made ready to be asked about its columns, a vector of them at a time. Above the eye
///   rise * min(max_x * a, max_z * b, 1 / near)
/// and below it rise * max(min_x * a, min_z * b) are both the smallest of products with rise.
struct Slope {
    V rise, a, b, limit;
    const float *x, *z;

    HWY_INLINE Slope(const HorizonWedges& wedges, const Bound& bound)
        : rise(hn::Set(d, bound.rise)), a(hn::Set(d, bound.a)), b(hn::Set(d, bound.b)) {
        const bool above = bound.rise > 0.0f;
        x = above ? wedges.max_x : wedges.min_x;
        z = above ? wedges.max_z : wedges.min_z;
        limit = hn::Set(d, above ? bound.rise * wedges.inverse_near : std::numeric_limits<float>::infinity());
    }
    [[nodiscard]] HWY_INLINE V tangents(int c) const {
        return hn::Min(
            hn::Min(hn::Mul(rise, hn::Mul(hn::LoadU(d, x + c), a)), hn::Mul(rise, hn::Mul(hn::LoadU(d, z + c), b))),
            limit);
    }
    /// Whether any column of [c, last), at most a vector of them, is raised.
    [[nodiscard]] HWY_INLINE bool raises(const float* old, int c, int last) const {
        const auto higher = hn::Gt(tangents(c), hn::LoadU(d, old + c));
        return !hn::AllFalse(d, hn::And(higher, hn::FirstN(d, std::size_t(last - c))));
    }
};

/// Calls visit(c, last) for vectors of a bound's columns, all but the first and the last of them whole, until it
/// returns true. @return whether it did.
template <class Visit>
HWY_INLINE bool any_columns(const HorizonWedges& wedges, const Bound& bound, const Visit& visit) {
    constexpr int kLanes = int(hn::MaxLanes(d));
    const int end = bound.first + bound.count;
    // Nearly all squares are seen in less than a vector of columns.
    if (HWY_LIKELY(bound.count <= kLanes && end <= wedges.columns)) return visit(bound.first, end);
    const int before_wrap = std::min(end, wedges.columns);
    for (int c = bound.first; c < before_wrap; c += kLanes)
        if (visit(c, before_wrap)) return true;
    for (int c = 0; c < end - wedges.columns; c += kLanes)
        if (visit(c, end - wedges.columns)) return true;
    return false;
}

/// Whether a bound raises any of its columns.
HWY_INLINE bool raises_any(const HorizonWedges& wedges, const Bound& bound, const float* tangents) {
    const Slope slope(wedges, bound);
    return any_columns(wedges, bound, [&](int c, int last) HWY_ATTR { return slope.raises(tangents, c, last); });
}

/// Bounds over a square's columns, by which its children are judged all at once.
struct Survey {
    float lowest;                      ///< of the tangents so far
    float max_x, max_z, min_x, min_z;  ///< of the wedges
};

HWY_INLINE Survey survey_columns(const HorizonWedges& wedges, const Bound& bound, const float* tangents) {
    const V infinity = hn::Set(d, std::numeric_limits<float>::infinity());
    V lowest = infinity;
    any_columns(wedges, bound, [&](int c, int last) HWY_ATTR {
        const auto inside = hn::FirstN(d, std::size_t(last - c));
        lowest = hn::Min(lowest, hn::IfThenElse(inside, hn::LoadU(d, tangents + c), infinity));
        return false;
    });
    Survey survey;
    survey.lowest = hn::GetLane(hn::MinOfLanes(d, lowest));
    // Between two axes |x| and |z| only rise or only fall.
    const int first = bound.first, end = first + bound.count, quarter = wedges.columns / 4;
    const int next_axis = first < 2 * quarter ? (first < quarter ? quarter : 2 * quarter)
                                              : (first < 3 * quarter ? 3 * quarter : wedges.columns);
    if (HWY_LIKELY(end <= next_axis)) {
        survey.max_x = std::max(wedges.max_x[first], wedges.max_x[end - 1]);
        survey.max_z = std::max(wedges.max_z[first], wedges.max_z[end - 1]);
        survey.min_x = std::min(wedges.min_x[first], wedges.min_x[end - 1]);
        survey.min_z = std::min(wedges.min_z[first], wedges.min_z[end - 1]);
    } else {
        survey.max_x = survey.max_z = 1.0f + 2e-6f;  // what the tables go up to
        survey.min_x = survey.min_z = 0.0f;
    }
    return survey;
}

/// Raises the columns of a bound to what it adds, and notes `id()` as the winner where `winner` is not null.
template <class Id>
HWY_INLINE void raise(const HorizonWedges& wedges, const Bound& bound, const Id& id, float* tangents,
                      std::uint32_t* winner) {
    const Slope slope(wedges, bound);
    any_columns(wedges, bound, [&](int c, int last) HWY_ATTR {
        const V tangent = slope.tangents(c), old = hn::LoadU(d, tangents + c);
        const auto higher = hn::And(hn::Gt(tangent, old), hn::FirstN(d, std::size_t(last - c)));
        if (HWY_LIKELY(hn::AllFalse(d, higher))) return false;
        hn::StoreU(hn::IfThenElse(higher, tangent, old), d, tangents + c);
        if (!winner) return false;
        std::int32_t* const who = reinterpret_cast<std::int32_t*>(winner) + c;
        const auto ids = hn::Set(di, std::int32_t(id()));
        hn::StoreU(hn::IfThenElse(hn::RebindMask(di, higher), ids, hn::LoadU(di, who)), di, who);
        return false;
    });
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#endif
