// Points are computed a register at a time. In the old orientation the step between the frames moves points along
// epipolar lines and nothing else does, so that order is tested there; only then are they turned into the new image.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/reproject_points.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/farfield/reproject_points.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::reprojection {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using MF = hn::Mask<F>;
constexpr F f;
constexpr I si;
constexpr U ui;
constexpr int kLanes = int(hn::MaxLanes(f));
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

constexpr std::int32_t kInfIndex = std::numeric_limits<std::int32_t>::max();

constexpr int kMaxWidth = 16384;

// Sky lies at this depth, where no step between two frames is seen.
constexpr float kSkyDepth = 1e15f;
// Metres of depth that a point needs for each metre of old depth.
constexpr float kLeastW = 1e-6f;

// Rounds to whole numbers of [0, 2^22]; all others, not-a-number too, become greater when taken as unsigned.
HWY_INLINE hn::Vec<U> rounded(VF numerator, VF per_denominator, float offset) {
    constexpr float kWholes = 8388608.0f;  // 2^23: floats from here on are whole
    const VF sum = hn::MulAdd(numerator, per_denominator, hn::Set(f, kWholes + offset));
    return hn::Sub(hn::BitCast(ui, sum), hn::BitCast(ui, hn::Set(f, kWholes)));
}

HWY_INLINE MF is_at_most(hn::Vec<U> value, std::uint32_t most) {
    return hn::RebindMask(f, hn::Eq(hn::Min(value, hn::Set(ui, most)), value));
}

// How far down the old image a register of points has come as the new eye sees them, rising with the rows.
struct Down {
    VF y, w;  // homogeneous
};
HWY_INLINE Down down_of(const PointsJob& job, int row, VF depth) {
    const float sign = job.v_step < 0.0f ? -1.0f : 1.0f, v = float(row) * job.v_step + job.v_first;
    return {hn::MulSub(depth, hn::Set(f, sign * v), hn::Set(f, sign * job.step.y)),
            hn::Sub(depth, hn::Set(f, job.step.z))};
}

HWY_INLINE VF depth_of(const float* depth) {
    return hn::Min(hn::LoadU(f, depth), hn::Set(f, kSkyDepth));
}

// Targets and tangents of one old row; what is no point has none.
// @param ahead  from a pixel to the one that comes a row later
HWY_INLINE void project_row(const PointsJob& job, int y, std::ptrdiff_t ahead, float* HWY_RESTRICT across,
                            float* HWY_RESTRICT down, ReprojectedPoints& points) {
    const std::size_t first = job.last.index(0, y);
    const std::uint32_t* HWY_RESTRICT const instances = job.last.instance.data() + first;
    const float* HWY_RESTRICT const depths = job.last.depth.data() + first;
    std::int32_t* HWY_RESTRICT const targets = points.target.data() + first;
    const int width = job.width;
    const bool check_order = job.check_order;
    // Homogeneous pixel coordinates in the new image are linear in x, for each depth.
    const Mat3& m = job.pixel_from_old;
    const float v = float(y) * job.v_step + job.v_first;
    VF per_x[3], of_row[3], step[3];
    for (int row = 0; row < 3; ++row) {
        per_x[row] = hn::Set(f, m[0][row] * job.u_step);
        of_row[row] = hn::Set(f, m[0][row] * job.u_first + m[1][row] * v + m[2][row]);
        step[row] = hn::Set(f, m[0][row] * job.step.x + m[1][row] * job.step.y + m[2][row] * job.step.z);
    }
    const VF u_step = hn::Set(f, job.u_step), u_first = hn::Set(f, job.u_first), step_x = hn::Set(f, job.step.x);
    const VF one = hn::Set(f, 1.0f), nan = hn::Set(f, kNan), least_w = hn::Set(f, kLeastW);
    const VF least_depth = hn::Set(f, job.least_depth);
    // Sky comes before the first instance, or behind the last.
    const auto name_offset = hn::Set(ui, job.use_background ? 1u : 0u);
    const auto names = hn::Set(ui, job.static_instances + (job.use_background ? 1u : 0u));
    const auto columns = std::uint32_t(width + 1), rows = std::uint32_t(job.height + 1);
    const auto stride = hn::Set(ui, std::uint32_t(job.auxiliary.stride));
    const auto origin = hn::Set(ui, std::uint32_t(job.auxiliary.index(-1, -1)));
    const auto outside = hn::Set(si, ReprojectedPoints::kOutside);
    const auto abrupt_bit = hn::Set(si, ReprojectedPoints::kAbruptBit);
    auto least = hn::BitCast(ui, outside);
    auto greatest = outside;
    for (int x = 0; x < width; x += kLanes) {
        __builtin_prefetch(instances + x + ahead);
        __builtin_prefetch(depths + x + ahead);
        MF valid = hn::RebindMask(f, hn::Lt(hn::Add(hn::LoadU(ui, instances + x), name_offset), names));
        if (HWY_UNLIKELY(x + kLanes > width)) valid = hn::And(valid, hn::FirstN(f, std::size_t(width - x)));
        const VF depth = depth_of(depths + x), column = hn::Iota(f, float(x));
        const VF least_here = hn::Mul(depth, least_w);
        const auto turned = [&](int row) {
            return hn::MulSub(depth, hn::MulAdd(column, per_x[row], of_row[row]), step[row]);
        };
        const VF w = turned(2);
        VF per_w;
        if (check_order) {
            const VF point_x = hn::MulSub(depth, hn::MulAdd(column, u_step, u_first), step_x);
            const Down point = down_of(job, y, depth);
            valid = hn::And(valid, hn::Gt(point.w, least_here));
            // One division for two.
            const VF per_both = hn::Div(one, hn::Mul(w, point.w)), per_point_w = hn::Mul(per_both, w);
            per_w = hn::Mul(per_both, point.w);
            hn::StoreU(hn::IfThenElse(valid, hn::Mul(point_x, per_point_w), nan), f, across + x);
            hn::StoreU(hn::IfThenElse(valid, hn::Mul(point.y, per_point_w), nan), f, down + x);
        } else {
            per_w = hn::Div(one, w);
        }
        const auto new_column = rounded(turned(0), per_w, 1.0f), new_row = rounded(turned(1), per_w, 1.0f);
        valid = hn::And(hn::And(valid, hn::Gt(w, least_here)),
                        hn::And(is_at_most(new_column, columns), is_at_most(new_row, rows)));
        const auto place = hn::BitCast(si, hn::Add(hn::Add(hn::Mul(new_row, stride), new_column), origin));
        const auto target = hn::IfThenElse(hn::RebindMask(si, valid), place, outside);
        least = hn::Min(least, hn::BitCast(ui, target));
        greatest = hn::Max(greatest, target);
        const auto is_abrupt = hn::RebindMask(si, hn::Lt(w, least_depth));
        hn::StoreU(hn::Or(target, hn::IfThenElseZero(is_abrupt, abrupt_bit)), si, targets + x);
    }
    points.last_target[std::size_t(y)] = hn::GetLane(hn::MaxOfLanes(si, greatest));
    // Of a row without points the first is the greatest of all.
    points.first_target[std::size_t(y)] =
        std::int32_t(std::min(hn::GetLane(hn::MinOfLanes(ui, least)), std::uint32_t(kInfIndex)));
}

// Walks a part of a row in one direction and takes out what does not pass the farthest so far.
template <bool kForwards>
HWY_INLINE void check_part(const float* across, std::int32_t* target, float* down, int begin, int end) {
    float farthest = -kInf;
    const auto check = [&](int x) {
        const float value = kForwards ? across[x] : -across[x];
        if (value > farthest) {
            farthest = value;
        } else {
            target[x] = ReprojectedPoints::kOutside;
            down[x] = kNan;
        }
    };
    // Where a register's values rise all along, as they do on surfaces, there is nothing to take out.
    int x = kForwards ? begin : end - 1;
    if (kForwards ? begin >= end : end <= begin) return;
    check(x);
    x += kForwards ? 1 : -1;
    while (kForwards ? x + kLanes <= end : x - kLanes + 1 >= begin) {
        const int low = kForwards ? x : x - kLanes + 1;
        const VF here = hn::LoadU(f, across + low);
        const VF before = hn::LoadU(f, across + low + (kForwards ? -1 : 1));
        const float start = kForwards ? across[x - 1] : -across[x + 1];
        const bool rises = hn::AllTrue(f, kForwards ? hn::Gt(here, before) : hn::Lt(here, before));
        if (rises && start >= farthest) {
            farthest = kForwards ? across[low + kLanes - 1] : -across[low];
            x += kForwards ? kLanes : -kLanes;
            continue;
        }
        for (int i = 0; i < kLanes; ++i, x += kForwards ? 1 : -1) check(x);
    }
    for (; kForwards ? x < end : x >= begin; x += kForwards ? 1 : -1) check(x);
}

// Takes out the points of a row that do not pass those of the band's rows before it.
HWY_INLINE void check_row_of_band(const PointsJob& job, const float* down, bool downwards, float* first_way,
                                  float* last_way, std::int32_t* target) {
    const VF sign = hn::Set(f, downwards ? 1.0f : -1.0f), inf = hn::Set(f, kInf);
    for (int x = 0; x < job.width; x += kLanes) {
        const VF way = hn::Mul(hn::LoadU(f, down + x), sign), farthest = hn::LoadU(f, last_way + x);
        const auto passes = hn::Gt(way, farthest);  // not-a-number does not
        hn::StoreU(hn::IfThenElse(passes, way, farthest), f, last_way + x);
        hn::StoreU(hn::Min(hn::LoadU(f, first_way + x), hn::IfThenElse(passes, way, inf)), f, first_way + x);
        if (HWY_LIKELY(hn::AllTrue(f, passes))) continue;
        hn::StoreU(hn::IfThenElse(hn::RebindMask(si, passes), hn::LoadU(si, target + x),
                                  hn::Set(si, ReprojectedPoints::kOutside)),
                   si, target + x);
    }
}

// Takes out the points of a register of columns in a band that do not pass `farthest`.
HWY_INLINE void check_columns_of_band(const PointsJob& job, const ReprojectedPoints::Band& band, int x, VF farthest,
                                      ReprojectedPoints& points) {
    const VF sign = hn::Set(f, band.downwards ? 1.0f : -1.0f);
    for (int y = band.begin; y < band.end; ++y) {
        const std::size_t at = job.last.index(x, y);
        const Down point = down_of(job, y, depth_of(job.last.depth.data() + at));
        const VF way = hn::Mul(hn::Mul(point.y, hn::Div(hn::Set(f, 1.0f), point.w)), sign);
        const auto passes = hn::RebindMask(si, hn::Gt(way, farthest));
        hn::StoreU(
            hn::IfThenElse(passes, hn::LoadU(si, points.target.data() + at), hn::Set(si, ReprojectedPoints::kOutside)),
            si, points.target.data() + at);
    }
}

}  // namespace

void ProjectBand(const PointsJob& job, std::size_t band_index, ReprojectedPoints& points) {
    alignas(64) float across[kMaxWidth], down[kMaxWidth];  // only what is used of them is ever touched
    const ReprojectedPoints::Band band = points.bands[band_index];
    float* const first_way = points.first_way.data() + band_index * std::size_t(job.last.stride);
    float* const last_way = points.last_way.data() + band_index * std::size_t(job.last.stride);
    if (job.check_order) {
        std::fill_n(first_way, job.last.stride, kInf);
        std::fill_n(last_way, job.last.stride, -kInf);
    }
    for (int i = 0; i < band.end - band.begin; ++i) {
        const int y = band.downwards ? band.begin + i : band.end - 1 - i;
        // The next row is asked for early: rows begin on pages of their own, where processors stop looking ahead.
        const std::ptrdiff_t ahead = i + 1 < band.end - band.begin ? (band.downwards ? 1 : -1) * job.last.stride : 0;
        project_row(job, y, ahead, across, down, points);
        if (!job.check_order) continue;
        std::int32_t* const target = points.target.data() + job.last.index(0, y);
        const auto check = [&](bool forwards, int begin, int end) {
            forwards ? check_part<true>(across, target, down, begin, end)
                     : check_part<false>(across, target, down, begin, end);
        };
        check(!job.columns.outward, 0, job.columns.split);
        check(job.columns.outward, job.columns.split, job.width);
        check_row_of_band(job, down, band.downwards, first_way, last_way, target);
    }
}

void CheckColumns(const PointsJob& job, int first_column, int last_column, ReprojectedPoints& points) {
    for (int x = first_column; x < last_column; x += kLanes) {
        VF farthest = hn::Set(f, -kInf);
        for (std::size_t i = 0; i < points.bands.size(); ++i) {
            const ReprojectedPoints::Band& band = points.bands[i];
            if (band.is_first) farthest = hn::Set(f, -kInf);
            const std::size_t at = i * std::size_t(job.last.stride) + std::size_t(x);
            // The points of a band rise along its walk: where the first has passed, all have.
            const VF first_way = hn::LoadU(f, points.first_way.data() + at);
            if (!hn::AllTrue(f, hn::Gt(first_way, farthest))) check_columns_of_band(job, band, x, farthest, points);
            farthest = hn::Max(farthest, hn::LoadU(f, points.last_way.data() + at));
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::reprojection
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::reprojection {
HWY_EXPORT(ProjectBand);
HWY_EXPORT(CheckColumns);

namespace {

/// Along an axis whose pixel i has the tangent i * step_tangent + first, image motion has the sign of
/// tangent * forward - sideways.
AxisOrder order_along(int size, float first, float step_tangent, float sideways, float forward) {
    const float sign = step_tangent < 0.0f ? -1.0f : 1.0f;
    const auto moves_on = [&](int i) { return sign * ((float(i) * step_tangent + first) * forward - sideways) > 0.0f; };
    AxisOrder order;
    order.outward = forward >= 0.0f;
    int low = 0, high = size;  // the first pixel that moves like the last part does
    while (low < high) {
        const int middle = (low + high) / 2;
        if (moves_on(middle) == order.outward)
            high = middle;
        else
            low = middle + 1;
    }
    order.split = low;
    return order;
}

}  // namespace

PointsJob::PointsJob(const PinholeView& last_view, const VisibilityBuffer& last_buffer, const PinholeView& view,
                     const ReprojectSettings& settings, std::uint32_t static_count)
    : last(last_buffer),
      static_instances(static_count),
      width(view.width),
      height(view.height),
      auxiliary(view.width, view.height),
      u_step(last_view.u_step),
      u_first(last_view.u_first + 0.5f * last_view.u_step),
      v_step(last_view.v_step),
      v_first(last_view.v_first + 0.5f * last_view.v_step),
      use_background(settings.use_background) {
    const DMat3 old_from_world = glm::transpose(DMat3(last_view.world_from_camera));
    const DVec3 moved = old_from_world * (view.position - last_view.position);
    step = Vec3(DVec3(moved.x, moved.y, -moved.z));
    const double length = glm::length(moved);
    least_depth = settings.check_abrupt ? float(length * 2.0 * settings.abrupt_frames) : 0.0f;
    check_order = settings.check_occlusion && length > 0.0;
    // (u, v, w) in old axes is the camera point (u, v, -w); a pixel of the new image is (u - u_first) / u_step - 0.5.
    const DMat3 new_from_old = glm::transpose(DMat3(view.world_from_camera)) * DMat3(last_view.world_from_camera);
    const double scale_x = 1.0 / double(view.u_step), scale_y = 1.0 / double(view.v_step);
    const double offset_x = -double(view.u_first) * scale_x - 0.5, offset_y = -double(view.v_first) * scale_y - 0.5;
    const DMat3 pixel_from_new(DVec3(scale_x, 0, 0), DVec3(0, scale_y, 0), DVec3(-offset_x, -offset_y, -1));
    const DMat3 flip(DVec3(1, 0, 0), DVec3(0, 1, 0), DVec3(0, 0, -1));
    pixel_from_old = Mat3(pixel_from_new * new_from_old * flip);
    columns = order_along(width, u_first, u_step, step.x, step.z);
    rows = order_along(height, v_first, v_step, step.y, step.z);
}

void begin_points(const PointsJob& job, ReprojectedPoints& points) {
    points.layout = job.auxiliary;
    points.resize(job.last);
    points.bands.clear();
    const auto add = [&](int begin, int end, bool downwards) {
        for (int first = 0; first < end - begin; first += ReprojectedPoints::kBandRows) {
            const int last = std::min(first + ReprojectedPoints::kBandRows, end - begin);
            points.bands.push_back({downwards ? begin + first : end - last, downwards ? begin + last : end - first,
                                    first == 0, downwards});
        }
    };
    add(0, job.rows.split, !job.rows.outward);
    add(job.rows.split, job.height, job.rows.outward);
    // The third of a point's new coordinates is depth over old depth.
    const Mat3& m = job.pixel_from_old;
    points.depth_per_x = m[0][2] * job.u_step;
    points.depth_per_y = m[1][2] * job.v_step;
    points.depth_constant = m[0][2] * job.u_first + m[1][2] * job.v_first + m[2][2];
    points.depth_step = m[0][2] * job.step.x + m[1][2] * job.step.y + m[2][2] * job.step.z;
}

void project_band(const PointsJob& job, std::size_t band, ReprojectedPoints& points) {
    HWY_DYNAMIC_DISPATCH(ProjectBand)(job, band, points);
}

void check_columns(const PointsJob& job, int first_column, int last_column, ReprojectedPoints& points) {
    HWY_DYNAMIC_DISPATCH(CheckColumns)(job, first_column, last_column, points);
}

}  // namespace ff::farfield::reprojection
#endif
