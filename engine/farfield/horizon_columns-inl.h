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
    int first, count;  ///< columns
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

template <bool kAbove>
HWY_INLINE V tangents_of(const HorizonWedges& wedges, std::size_t c, V rise, V a, V b, V inverse_near) {
    if (kAbove)
        return hn::Mul(rise, hn::Min(hn::Min(hn::Mul(hn::LoadU(d, wedges.max_x + c), a),
                                             hn::Mul(hn::LoadU(d, wedges.max_z + c), b)),
                                     inverse_near));
    return hn::Mul(rise,
                   hn::Max(hn::Mul(hn::LoadU(d, wedges.min_x + c), a), hn::Mul(hn::LoadU(d, wedges.min_z + c), b)));
}

/// Bounds over a square's columns, by which its children are judged all at once.
struct Survey {
    float lowest;                      ///< of the tangents so far
    float max_x, max_z, min_x, min_z;  ///< of the wedges
};

/// Whether a bound raises any of its columns.
template <bool kAbove>
HWY_INLINE bool raises_any(const HorizonWedges& wedges, const Bound& bound, const float* tangents) {
    const V rise = hn::Set(d, bound.rise), a = hn::Set(d, bound.a), b = hn::Set(d, bound.b);
    const V inverse_near = hn::Set(d, wedges.inverse_near);
    const auto range = [&](int first, int last) HWY_ATTR {
        for (int c = first; c < last; c += int(hn::Lanes(d))) {
            const auto higher = hn::Gt(tangents_of<kAbove>(wedges, std::size_t(c), rise, a, b, inverse_near),
                                       hn::LoadU(d, tangents + c));
            if (!hn::AllFalse(d, hn::And(higher, hn::FirstN(d, std::size_t(last - c))))) return true;
        }
        return false;
    };
    const int end = bound.first + bound.count;
    if (HWY_LIKELY(end <= wedges.columns)) return range(bound.first, end);
    return range(bound.first, wedges.columns) || range(0, end - wedges.columns);
}

HWY_INLINE bool raises_any_sign(const HorizonWedges& wedges, const Bound& bound, const float* tangents) {
    return bound.rise > 0.0f ? raises_any<true>(wedges, bound, tangents) : raises_any<false>(wedges, bound, tangents);
}

inline Survey survey_columns(const HorizonWedges& wedges, const Bound& bound, const float* tangents) {
    V lowest = hn::Set(d, std::numeric_limits<float>::infinity());
    V max_x = hn::Zero(d), max_z = max_x, min_x = hn::Set(d, 1.0f), min_z = min_x;
    const auto range = [&](int first, int last) HWY_ATTR {
        for (int c = first; c < last; c += int(hn::Lanes(d))) {
            const auto inside = hn::FirstN(d, std::size_t(last - c));
            lowest = hn::IfThenElse(inside, hn::Min(lowest, hn::LoadU(d, tangents + c)), lowest);
            max_x = hn::Max(max_x, hn::IfThenElseZero(inside, hn::LoadU(d, wedges.max_x + c)));
            max_z = hn::Max(max_z, hn::IfThenElseZero(inside, hn::LoadU(d, wedges.max_z + c)));
            min_x = hn::IfThenElse(inside, hn::Min(min_x, hn::LoadU(d, wedges.min_x + c)), min_x);
            min_z = hn::IfThenElse(inside, hn::Min(min_z, hn::LoadU(d, wedges.min_z + c)), min_z);
        }
    };
    const int end = bound.first + bound.count;
    range(bound.first, std::min(end, wedges.columns));
    if (end > wedges.columns) range(0, end - wedges.columns);
    Survey survey;
    survey.lowest = hn::GetLane(hn::MinOfLanes(d, lowest));
    survey.max_x = hn::GetLane(hn::MaxOfLanes(d, max_x));
    survey.max_z = hn::GetLane(hn::MaxOfLanes(d, max_z));
    survey.min_x = hn::GetLane(hn::MinOfLanes(d, min_x));
    survey.min_z = hn::GetLane(hn::MinOfLanes(d, min_z));
    return survey;
}

/// Raises the columns of a bound to what it adds, and notes `id` as the winner where `winner` is not null.
template <bool kAbove>
void raise(const HorizonWedges& wedges, const Bound& bound, std::uint32_t id, float* tangents, std::uint32_t* winner) {
    const V rise = hn::Set(d, bound.rise), a = hn::Set(d, bound.a), b = hn::Set(d, bound.b);
    const V inverse_near = hn::Set(d, wedges.inverse_near);
    const auto ids = hn::Set(di, std::int32_t(id));
    const int end = bound.first + bound.count;
    const auto range = [&](int first, int last) HWY_ATTR {
        for (int c = first; c < last; c += int(hn::Lanes(d))) {
            const V old = hn::LoadU(d, tangents + c);
            const V tangent = tangents_of<kAbove>(wedges, std::size_t(c), rise, a, b, inverse_near);
            const auto higher = hn::And(hn::Gt(tangent, old), hn::FirstN(d, std::size_t(last - c)));
            if (hn::AllFalse(d, higher)) continue;
            hn::StoreU(hn::IfThenElse(higher, tangent, old), d, tangents + c);
            if (!winner) continue;
            std::int32_t* const who = reinterpret_cast<std::int32_t*>(winner) + c;
            hn::StoreU(hn::IfThenElse(hn::RebindMask(di, higher), ids, hn::LoadU(di, who)), di, who);
        }
    };
    if (end <= wedges.columns) return range(bound.first, end);
    range(bound.first, wedges.columns);
    range(0, end - wedges.columns);
}

HWY_INLINE void raise_any_sign(const HorizonWedges& wedges, const Bound& bound, std::uint32_t id, float* tangents,
                               std::uint32_t* winner) {
    if (bound.rise > 0.0f)
        raise<true>(wedges, bound, id, tangents, winner);
    else
        raise<false>(wedges, bound, id, tangents, winner);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#endif
