#include "engine/farfield/reproject.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/reproject_changes.h"
#include "engine/farfield/reproject_points.h"

namespace ff::farfield {
namespace {

constexpr std::size_t kColumnsPerTask = 64;

/// P3 4.1: whether what the eye sees may have been outside of the last image though it stands before nothing new. The
/// last eye itself counts as inside.
bool is_inside_frustum(const WorldPos& eye, const PinholeView& view) {
    const DVec3 moved = eye - view.position;
    const DVec3 camera = glm::transpose(DMat3(view.world_from_camera)) * moved;
    if (camera == DVec3(0.0)) return true;
    const double forward = -camera.z;
    const double x = (camera.x - double(view.u_first) * forward) / double(view.u_step);
    const double y = (camera.y - double(view.v_first) * forward) / double(view.v_step);
    return forward > 0.0 && x >= 0.0 && x <= view.width * forward && y >= 0.0 && y <= view.height * forward;
}

}  // namespace

void ReprojectedPoints::resize(const VisibilityBuffer& like) {
    if (target.size() == like.instance.size() && first_target.size() == std::size_t(like.height)) return;
    target.assign(like.instance.size(), kOutside);
    first_target.assign(std::size_t(like.height), 0);
    last_target.assign(std::size_t(like.height), 0);
    const auto most_bands = std::size_t(like.height / kBandRows + 3);  // the epipole's row divides one
    bands.reserve(most_bands);
    for (auto* ways : {&first_way, &last_way}) ways->assign(most_bands * std::size_t(like.stride), 0.0f);
}

PixelCause Reprojection::Causes::at(int x, int y) const {
    if (verified.test(x, y)) return PixelCause::verified;
    if (background.test(x, y)) return PixelCause::background;
    if (resampled.test(x, y)) return PixelCause::resampled;
    return abrupt.test(x, y) ? PixelCause::abrupt : PixelCause::failed;
}

void Reprojection::invalidate(const DBox3& box) {
    constexpr std::size_t kMost = 16;  // the last one holds all that come later
    if (box.is_empty()) return;
    if (changed_.size() < kMost)
        changed_.push_back(box);
    else
        changed_.back().add(box);
}

bool Reprojection::reproject(const PinholeView& last_view, const VisibilityBuffer& last, const PinholeView& view,
                             const ReprojectSettings& settings) {
    FF_CHECK(last_view.width == view.width && last_view.height == view.height && last.width == view.width &&
                 last.height == view.height,
             "a view of {}x{} after one of {}x{} in a buffer of {}x{}", view.width, view.height, last_view.width,
             last_view.height, last.width, last.height);
    FF_CHECK(view.width <= 16384, "a view {} pixels wide", view.width);
    if (settings.check_view_frustum && !is_inside_frustum(view.position, last_view)) {
        changed_.clear();  // all is cast
        return false;
    }
    using namespace reprojection;
    const PointsJob job(last_view, last, view, settings, std::uint32_t(scene_.instances.size()));
    begin_points(job, points_);
    parallel_for(points_.bands.size(), [&](std::size_t band) { project_band(job, band, points_); });
    if (job.check_order)
        parallel_ranges(std::size_t(last.stride), kColumnsPerTask,
                        [&](std::size_t begin, std::size_t end) { check_columns(job, int(begin), int(end), points_); });
    drop_points(changed_, last_view, last, points_);
    return true;
}

}  // namespace ff::farfield
