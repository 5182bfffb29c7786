#include "engine/budget/governor.h"

#include <algorithm>

namespace ff::budget {

double predicted_near_and_cast_ms(const Outlook& outlook, const CostModel& costs, std::size_t i) {
    const double left_over = std::max(0.0, outlook.pixels - outlook.sky_pixels - outlook.near_pixels[i]);
    const double near_ms =
        kNearDistances[i] > 0.0 ? costs.near_fixed_ms + costs.near_triangle.ms_for(outlook.near_triangles[i]) : 0.0;
    return near_ms + costs.cast_ray.ms_for(left_over);
}

Choice Governor::choose(const Outlook& outlook, const CostModel& costs, double budget_ms) {
    // Near distance: the cheapest, if it stays clearly cheaper than the present one.
    std::size_t best = 0;
    for (std::size_t i = 1; i < kNearDistances.size(); ++i)
        if (predicted_near_and_cast_ms(outlook, costs, i) < predicted_near_and_cast_ms(outlook, costs, best)) best = i;
    const double present_ms = predicted_near_and_cast_ms(outlook, costs, near_index_);
    const bool clearly = predicted_near_and_cast_ms(outlook, costs, best) < (1.0 - kSwitchGain) * present_ms;
    near_votes_ = clearly && best != near_index_ ? near_votes_ + 1 : 0;
    if (near_votes_ >= kPatience) {
        near_index_ = best;
        near_votes_ = 0;
    }

    // Panorama: a lookup of everything left over must save more casting and shading than it costs.
    const double candidates = std::max(0.0, outlook.pixels - outlook.sky_pixels - outlook.near_pixels[near_index_]);
    const double saved_ms = (costs.cast_ray.ms_for(1) + costs.shade_pixel.ms_for(1)) * outlook.reusable_pixels;
    const double spent_ms =
        costs.lookup_pixel.ms_for(candidates) + costs.store_pixel.ms_for(candidates - outlook.reusable_pixels);
    const bool pays = look_up_ ? saved_ms > spent_ms : saved_ms > (1.0 + kSwitchGain) * spent_ms;
    look_up_votes_ = pays != look_up_ ? look_up_votes_ + 1 : 0;
    if (look_up_votes_ >= kPatience) {
        look_up_ = pays;
        look_up_votes_ = 0;
    }

    Choice choice;
    choice.near_m = kNearDistances[near_index_];
    choice.look_up_panorama = look_up_;
    const double fixed_ms = predicted_near_and_cast_ms(outlook, costs, near_index_) -
                            costs.cast_ray.ms_for(candidates) + costs.horizon_azimuth.ms_for(outlook.horizon_azimuths) +
                            costs.shade_pixel.ms_for(outlook.near_pixels[near_index_]) +
                            (budget_ms > 0.0 || look_up_ ? costs.lookup_pixel.ms_for(candidates) : 0.0);
    const double ms_per_ray = costs.cast_ray.ms_for(1) + costs.shade_pixel.ms_for(1);
    double rays = candidates - (look_up_ ? outlook.reusable_pixels : 0.0);
    if (budget_ms > 0.0) {
        const double affordable = std::max(0.02 * outlook.pixels, (kAim * budget_ms - fixed_ms) / ms_per_ray);
        ray_budget_ =
            ray_budget_ < 0.0 ? affordable : std::clamp(affordable, ray_budget_ / kRayStep, ray_budget_ * kRayStep);
        ray_budget_ = std::min(ray_budget_, outlook.pixels);
        choice.ray_budget = static_cast<std::uint64_t>(ray_budget_);
        if (ray_budget_ < rays) choice.look_up_panorama = true;  // what is not cast must come from somewhere
        rays = std::min(rays, ray_budget_);
    } else {
        ray_budget_ = -1.0;
    }
    choice.predicted_ms = fixed_ms + ms_per_ray * rays;
    return choice;
}

}  // namespace ff::budget
