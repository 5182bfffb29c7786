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
constexpr F f;
constexpr I si;
constexpr U ui;
constexpr int kLanes = int(hn::MaxLanes(f));
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

constexpr int kMaxWidth = 16384;

// Targets, depths and tangents of one old row.
HWY_INLINE void project_row(const PointsJob& job, int y, float* HWY_RESTRICT across, ReprojectedPoints& points) {
    const VisibilityBuffer& last = job.last;
    const std::size_t first = last.index(0, y);
    const Mat3& m = job.pixel_from_old;
    const VF v = hn::Set(f, float(y) * job.v_step + job.v_first);
    const VF one = hn::Set(f, 1.0f), zero = hn::Zero(f), half = hn::Set(f, 0.5f);
    const float v_sign = job.v_step < 0.0f ? -1.0f : 1.0f;
    auto least = hn::Set(si, std::numeric_limits<std::int32_t>::max());
    auto greatest = hn::Set(si, ReprojectedPoints::kOutside);
    for (int x = 0; x < job.width; x += kLanes) {
        const std::size_t at = first + std::size_t(x);
        const auto instance = hn::LoadU(ui, last.instance.data() + at);
        const auto is_sky = hn::RebindMask(f, hn::Eq(instance, hn::Set(ui, kSkyInstance)));
        auto valid = hn::RebindMask(f, hn::Lt(instance, hn::Set(ui, job.static_instances)));
        if (job.use_background) valid = hn::Or(valid, is_sky);
        valid = hn::And(valid, hn::RebindMask(f, hn::Lt(hn::Iota(si, x), hn::Set(si, job.width))));

        // The point in the old orientation, from the new eye, divided by its old depth.
        const VF old_depth = hn::LoadU(f, last.depth.data() + at);
        const VF per_depth = hn::IfThenElse(is_sky, zero, hn::Div(one, old_depth));
        const VF u = hn::MulAdd(hn::Iota(f, float(x)), hn::Set(f, job.u_step), hn::Set(f, job.u_first));
        const VF px = hn::NegMulAdd(hn::Set(f, job.step.x), per_depth, u);
        const VF py = hn::NegMulAdd(hn::Set(f, job.step.y), per_depth, v);
        const VF pw = hn::NegMulAdd(hn::Set(f, job.step.z), per_depth, one);
        constexpr float kLeastW = 1e-6f;
        valid = hn::And(valid, hn::Gt(pw, hn::Set(f, kLeastW)));
        const VF per_w = hn::Div(one, pw);
        if (job.check_order) {
            const VF nan = hn::Set(f, kNan);
            hn::StoreU(hn::IfThenElse(valid, hn::Mul(px, per_w), nan), f, across + x);
            hn::StoreU(hn::IfThenElse(valid, hn::Mul(hn::Mul(py, per_w), hn::Set(f, v_sign)), nan), f,
                       points.down.data() + at);
        }

        const auto turned = [&](int row) {
            return hn::MulAdd(hn::Set(f, m[0][row]), px,
                              hn::MulAdd(hn::Set(f, m[1][row]), py, hn::Mul(hn::Set(f, m[2][row]), pw)));
        };
        const VF w = turned(2);
        valid = hn::And(valid, hn::Gt(w, hn::Set(f, kLeastW)));
        const VF per_new_w = hn::Div(one, w);
        const VF column = hn::Floor(hn::MulAdd(turned(0), per_new_w, half));
        const VF row = hn::Floor(hn::MulAdd(turned(1), per_new_w, half));
        const VF outside = hn::Set(f, -1.0f);
        valid = hn::And(valid, hn::And(hn::Ge(column, outside), hn::Le(column, hn::Set(f, float(job.width)))));
        valid = hn::And(valid, hn::And(hn::Ge(row, outside), hn::Le(row, hn::Set(f, float(job.height)))));
        const VF depth = hn::IfThenElse(is_sky, hn::Set(f, kInf), hn::Mul(w, old_depth));
        hn::StoreU(depth, f, points.depth.data() + at);

        const auto valid_i = hn::RebindMask(si, valid);
        const auto column_i = hn::ConvertTo(si, hn::IfThenElseZero(valid, column));
        const auto row_i = hn::ConvertTo(si, hn::IfThenElseZero(valid, row));
        auto target = hn::Add(hn::Add(hn::Mul(row_i, hn::Set(si, job.auxiliary_stride)), column_i),
                              hn::Set(si, job.auxiliary_first));
        least = hn::IfThenElse(valid_i, hn::Min(least, target), least);
        greatest = hn::IfThenElse(valid_i, hn::Max(greatest, target), greatest);
        const auto is_abrupt = hn::RebindMask(si, hn::Lt(depth, hn::Set(f, job.least_depth)));
        target = hn::Or(target, hn::IfThenElseZero(is_abrupt, hn::Set(si, ReprojectedPoints::kAbruptBit)));
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

template <bool kDown>
HWY_INLINE void check_part_of_columns(const PointsJob& job, int first_column, int begin, int end,
                                      ReprojectedPoints& points) {
    VF farthest = hn::Set(f, -kInf);
    for (int i = 0; i < end - begin; ++i) {
        const int y = kDown ? begin + i : end - 1 - i;
        const std::size_t at = job.last.index(first_column, y);
        const VF loaded = hn::LoadU(f, points.down.data() + at);
        const VF value = kDown ? loaded : hn::Neg(loaded);
        const auto passes = hn::Gt(value, farthest);  // not-a-number does not
        farthest = hn::IfThenElse(passes, value, farthest);
        if (HWY_LIKELY(hn::AllTrue(f, passes))) continue;
        const auto target = hn::LoadU(si, points.target.data() + at);
        hn::StoreU(hn::IfThenElse(hn::RebindMask(si, passes), target, hn::Set(si, ReprojectedPoints::kOutside)), si,
                   points.target.data() + at);
    }
}

}  // namespace

void ProjectRows(const PointsJob& job, int first_row, int last_row, ReprojectedPoints& points) {
    alignas(64) float across[kMaxWidth];  // only what is used of it is ever touched
    for (int y = first_row; y < last_row; ++y) {
        project_row(job, y, across, points);
        if (!job.check_order) continue;
        const std::size_t first = job.last.index(0, y);
        const auto check = [&](bool forwards, int begin, int end) {
            float* const down = points.down.data() + first;
            std::int32_t* const target = points.target.data() + first;
            forwards ? check_part<true>(across, target, down, begin, end)
                     : check_part<false>(across, target, down, begin, end);
        };
        check(!job.columns.outward, 0, job.columns.split);
        check(job.columns.outward, job.columns.split, job.width);
    }
}

void CheckColumns(const PointsJob& job, int first_column, int last_column, ReprojectedPoints& points) {
    for (int x = first_column; x < last_column; x += kLanes) {
        const int split = job.rows.split;
        if (job.rows.outward) {
            check_part_of_columns<false>(job, x, 0, split, points);
            check_part_of_columns<true>(job, x, split, job.height, points);
        } else {
            check_part_of_columns<true>(job, x, 0, split, points);
            check_part_of_columns<false>(job, x, split, job.height, points);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::reprojection
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::reprojection {
HWY_EXPORT(ProjectRows);
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
                     const ReprojectSettings& settings, std::uint32_t static_count, const AuxiliaryImage& auxiliary)
    : last(last_buffer),
      static_instances(static_count),
      width(view.width),
      height(view.height),
      auxiliary_stride(auxiliary.stride),
      auxiliary_first(int(auxiliary.index(0, 0))),
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

void project_rows(const PointsJob& job, int first_row, int last_row, ReprojectedPoints& points) {
    HWY_DYNAMIC_DISPATCH(ProjectRows)(job, first_row, last_row, points);
}

void check_columns(const PointsJob& job, int first_column, int last_column, ReprojectedPoints& points) {
    HWY_DYNAMIC_DISPATCH(CheckColumns)(job, first_column, last_column, points);
}

}  // namespace ff::farfield::reprojection
#endif
