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

constexpr int kMaxWidth = 16384;

// A register of old points in the old orientation, from the new eye, divided by their old depths.
struct OldPoints {
    VF x, y, w;
};
HWY_INLINE OldPoints points_of(const PointsJob& job, int x, VF v, VF depth, MF is_sky) {
    const VF one = hn::Set(f, 1.0f);
    const VF per_depth = hn::IfThenElse(is_sky, hn::Zero(f), hn::Div(one, depth));
    const VF u = hn::MulAdd(hn::Iota(f, float(x)), hn::Set(f, job.u_step), hn::Set(f, job.u_first));
    return {hn::NegMulAdd(hn::Set(f, job.step.x), per_depth, u), hn::NegMulAdd(hn::Set(f, job.step.y), per_depth, v),
            hn::NegMulAdd(hn::Set(f, job.step.z), per_depth, one)};
}

// How far down the old image a point has come, rising with its rows.
HWY_INLINE VF down_of(const PointsJob& job, const OldPoints& point, VF per_w) {
    return hn::Mul(hn::Mul(point.y, per_w), hn::Set(f, job.v_step < 0.0f ? -1.0f : 1.0f));
}

HWY_INLINE VF tangent_of_row(const PointsJob& job, int y) {
    return hn::Set(f, float(y) * job.v_step + job.v_first);
}

// Targets and tangents of one old row; what is no point has none.
HWY_INLINE void project_row(const PointsJob& job, int y, float* HWY_RESTRICT across, float* HWY_RESTRICT down,
                            ReprojectedPoints& points) {
    const VisibilityBuffer& last = job.last;
    const std::size_t first = last.index(0, y);
    const Mat3& m = job.pixel_from_old;
    const VF v = tangent_of_row(job, y);
    const VF one = hn::Set(f, 1.0f), half = hn::Set(f, 0.5f), nan = hn::Set(f, kNan);
    auto least = hn::Set(si, std::numeric_limits<std::int32_t>::max());
    auto greatest = hn::Set(si, ReprojectedPoints::kOutside);
    for (int x = 0; x < job.width; x += kLanes) {
        const std::size_t at = first + std::size_t(x);
        const auto instance = hn::LoadU(ui, last.instance.data() + at);
        const auto is_sky = hn::RebindMask(f, hn::Eq(instance, hn::Set(ui, kSkyInstance)));
        auto valid = hn::RebindMask(f, hn::Lt(instance, hn::Set(ui, job.static_instances)));
        if (job.use_background) valid = hn::Or(valid, is_sky);
        valid = hn::And(valid, hn::RebindMask(f, hn::Lt(hn::Iota(si, x), hn::Set(si, job.width))));

        const VF old_depth = hn::LoadU(f, last.depth.data() + at);
        const OldPoints point = points_of(job, x, v, old_depth, is_sky);
        constexpr float kLeastW = 1e-6f;
        valid = hn::And(valid, hn::Gt(point.w, hn::Set(f, kLeastW)));
        if (job.check_order) {
            const VF per_w = hn::Div(one, point.w);
            hn::StoreU(hn::IfThenElse(valid, hn::Mul(point.x, per_w), nan), f, across + x);
            hn::StoreU(hn::IfThenElse(valid, down_of(job, point, per_w), nan), f, down + x);
        }

        const auto turned = [&](int row) {
            return hn::MulAdd(hn::Set(f, m[0][row]), point.x,
                              hn::MulAdd(hn::Set(f, m[1][row]), point.y, hn::Mul(hn::Set(f, m[2][row]), point.w)));
        };
        const VF w = turned(2);
        valid = hn::And(valid, hn::Gt(w, hn::Set(f, kLeastW)));
        const VF per_new_w = hn::Div(one, w);
        const VF column = hn::Floor(hn::MulAdd(turned(0), per_new_w, half));
        const VF row = hn::Floor(hn::MulAdd(turned(1), per_new_w, half));
        const VF outside = hn::Set(f, -1.0f);
        valid = hn::And(valid, hn::And(hn::Ge(column, outside), hn::Le(column, hn::Set(f, float(job.width)))));
        valid = hn::And(valid, hn::And(hn::Ge(row, outside), hn::Le(row, hn::Set(f, float(job.height)))));

        const auto valid_i = hn::RebindMask(si, valid);
        const auto column_i = hn::ConvertTo(si, hn::IfThenElseZero(valid, column));
        const auto row_i = hn::ConvertTo(si, hn::IfThenElseZero(valid, row));
        auto target = hn::Add(hn::Add(hn::Mul(row_i, hn::Set(si, job.auxiliary.stride)), column_i),
                              hn::Set(si, job.auxiliary.index(0, 0)));
        least = hn::IfThenElse(valid_i, hn::Min(least, target), least);
        greatest = hn::IfThenElse(valid_i, hn::Max(greatest, target), greatest);
        // Sky is nowhere near.
        const auto is_abrupt = hn::AndNot(is_sky, hn::Lt(hn::Mul(w, old_depth), hn::Set(f, job.least_depth)));
        target = hn::Or(target,
                        hn::IfThenElseZero(hn::RebindMask(si, is_abrupt), hn::Set(si, ReprojectedPoints::kAbruptBit)));
        hn::StoreU(hn::IfThenElse(valid_i, target, hn::Set(si, ReprojectedPoints::kOutside)), si,
                   points.target.data() + at);
    }
    points.first_target[std::size_t(y)] = hn::GetLane(hn::MinOfLanes(si, least));
    points.last_target[std::size_t(y)] = hn::GetLane(hn::MaxOfLanes(si, greatest));
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
        const auto is_sky =
            hn::RebindMask(f, hn::Eq(hn::LoadU(ui, job.last.instance.data() + at), hn::Set(ui, kSkyInstance)));
        const OldPoints point =
            points_of(job, x, tangent_of_row(job, y), hn::LoadU(f, job.last.depth.data() + at), is_sky);
        const VF way = hn::Mul(down_of(job, point, hn::Div(hn::Set(f, 1.0f), point.w)), sign);
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
        project_row(job, y, across, down, points);
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
