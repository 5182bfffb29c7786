#include "engine/budget/governor.h"

#include <algorithm>
#include <cmath>

namespace ff::budget {

double predicted_near_and_cast_ms(const Outlook& outlook, const CostModel& costs, std::size_t i) {
    const double left_over = std::max(0.0, outlook.pixels - outlook.sky_pixels - outlook.near_pixels[i]);
    const double near_ms =
        kNearDistances[i] > 0.0 ? costs.near_fixed_ms + costs.near_triangle.ms_for(outlook.near_triangles[i]) : 0.0;
    return near_ms + costs.cast_ray.ms_for(left_over);
}

namespace {

/// Pixels that the horizon and the near field leave over.
double left_over_pixels(const Outlook& outlook, std::size_t i) {
    return std::max(0.0, outlook.pixels - outlook.sky_pixels - outlook.near_pixels[i]);
}

double ray_ms(const CostModel& costs) {
    return costs.cast_ray.ms_for(1) + costs.shade_pixel.ms_for(1);
}

/// Time that does not depend on how many rays are cast.
double fixed_ms(const Outlook& outlook, const CostModel& costs, std::size_t i, bool look_up) {
    return predicted_near_and_cast_ms(outlook, costs, i) - costs.cast_ray.ms_for(left_over_pixels(outlook, i)) +
           costs.horizon_azimuth.ms_for(outlook.horizon_azimuths) + costs.shade_pixel.ms_for(outlook.near_pixels[i]) +
           (look_up ? costs.lookup_pixel.ms_for(left_over_pixels(outlook, i)) : 0.0);
}

/// How good a near distance is, smaller is better: its time where the budget suffices or there is none. Else
/// WhenLate::coarser: the budget by the share of the pixels that it affords; WhenLate::stale: the budget and the time
/// of the pixels that it could not answer; and ten times what cannot be cut.
double score(const Outlook& outlook, const CostModel& costs, double budget_ms, WhenLate when_late, std::size_t i) {
    const bool stale = budget_ms > 0.0 && when_late == WhenLate::stale;
    const double cast_ms = ray_ms(costs) * left_over_pixels(outlook, i);
    const double fixed = fixed_ms(outlook, costs, i, stale);
    const double aim_ms = Governor::kAim * budget_ms;
    if (budget_ms <= 0.0 || fixed + cast_ms <= aim_ms) return fixed + cast_ms;
    const double room = std::max(0.0, aim_ms - fixed), overrun = std::max(0.0, fixed - aim_ms);
    if (stale) return aim_ms + (cast_ms - room) + 10.0 * overrun;
    constexpr double kLeastShare = kResolutions.back() * kResolutions.back();
    return aim_ms / std::max(kLeastShare, room / cast_ms) + 10.0 * overrun;
}

}  // namespace

void Governor::choose_resolution(double rays, double upscale_rays, double needed) {
    const auto affords = [&](std::size_t i, double room) {
        return room * kResolutions[i] * kResolutions[i] * needed <= rays - (i > 0 ? upscale_rays : 0.0);
    };
    while (resolution_index_ + 1 < kResolutions.size() && !affords(resolution_index_, 1.0)) ++resolution_index_;
    // The whole picture needs no enlarging: it may fit where one a little smaller does not.
    const bool whole = resolution_index_ > 0 && affords(0, kFinerRoom);
    const bool finer = whole || (resolution_index_ > 0 && affords(resolution_index_ - 1, kFinerRoom));
    finer_votes_ = finer ? finer_votes_ + 1 : 0;
    if (finer_votes_ < kPatience) return;
    resolution_index_ = whole ? 0 : resolution_index_ - 1;
    finer_votes_ = 0;
}

Choice Governor::choose(const Outlook& outlook, const CostModel& costs, double budget_ms, WhenLate when_late) {
    const bool keep_old = budget_ms > 0.0 && when_late == WhenLate::stale;
    // Near distance: the best, if it stays clearly better than the present one.
    std::array<double, kNearDistances.size()> score_ms;
    for (std::size_t i = 0; i < kNearDistances.size(); ++i)
        score_ms[i] = score(outlook, costs, budget_ms, when_late, i);
    const auto best = std::size_t(std::min_element(score_ms.begin(), score_ms.end()) - score_ms.begin());
    const bool clearly = score_ms[best] < (1.0 - kSwitchGain) * score_ms[near_index_];
    near_votes_ = clearly ? near_votes_ + 1 : 0;
    if (near_votes_ >= kPatience) {
        near_index_ = best;
        near_votes_ = 0;
    }

    // Panorama: a lookup of everything left over must save more casting and shading than it costs.
    const double candidates = left_over_pixels(outlook, near_index_);
    // The near field may cover what could be reused.
    const double reusable = std::min(outlook.reusable_pixels, candidates);
    const double saved_ms = (costs.cast_ray.ms_for(1) + costs.shade_pixel.ms_for(1)) * reusable;
    const double spent_ms = costs.lookup_pixel.ms_for(candidates) + costs.store_pixel.ms_for(candidates - reusable);
    const bool pays = look_up_ ? saved_ms > spent_ms : saved_ms > (1.0 + kSwitchGain) * spent_ms;
    look_up_votes_ = pays != look_up_ ? look_up_votes_ + 1 : 0;
    if (look_up_votes_ >= kPatience) {
        look_up_ = pays;
        look_up_votes_ = 0;
    }

    Choice choice;
    choice.near_m = kNearDistances[near_index_];
    choice.look_up_panorama = look_up_;
    double fixed = fixed_ms(outlook, costs, near_index_, keep_old || look_up_);
    double rays = candidates - (look_up_ ? reusable : 0.0);
    if (budget_ms > 0.0) {
        const double affordable = std::max(kMinRayShare * outlook.pixels, (kAim * budget_ms - fixed) / ray_ms(costs));
        ray_budget_ =
            ray_budget_ < 0.0 ? affordable : std::clamp(affordable, ray_budget_ / kRayStep, ray_budget_ * kRayStep);
        ray_budget_ = std::min(ray_budget_, 2.0 * outlook.pixels);
        choice.affordable_rays = ray_budget_;
        choice.needed_rays = rays;
        if (keep_old) {
            choice.ray_budget = static_cast<std::uint64_t>(ray_budget_);
            if (ray_budget_ < rays) choice.look_up_panorama = true;  // what is not cast must come from somewhere
            rays = std::min(rays, ray_budget_);
        } else {
            const double upscale_ms = costs.upscale_pixel.ms_for(outlook.pixels);
            const double upscale_rays = upscale_ms / std::max(1e-12, ray_ms(costs));
            choose_resolution(ray_budget_, upscale_rays, candidates);
            choice.resolution = kResolutions[resolution_index_];
            if (resolution_index_ > 0) {
                fixed += upscale_ms;
                choice.affordable_rays = std::max(kMinRayShare * outlook.pixels, ray_budget_ - upscale_rays);
            }
            rays = choice.resolution * choice.resolution * candidates;
        }
    } else {
        ray_budget_ = -1.0;
        resolution_index_ = 0;
    }
    choice.predicted_ms = fixed + ray_ms(costs) * rays;
    return choice;
}

}  // namespace ff::budget
