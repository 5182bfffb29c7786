#include "engine/animation/seen_bounds.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace ff::animation {
namespace {

/// A shadow that covers less of a pixel than this is none.
constexpr double kLeastShadowPx = 0.25;

}  // namespace

SeenBounds::SeenBounds(const scene::StaticScene& scene, const PinholeView& view)
    : frustum_(visibility::make_frustum(view)),
      pixel_angle_(view.pixel_angle()),
      has_shadows_(scene.environment.sun_shadows && scene.environment.to_sun.y > 0.0f && !scene.bounds.is_empty()),
      to_sun_(scene.environment.to_sun),
      floor_y_(scene.bounds.low.y),
      reach_m_(has_shadows_ ? glm::length(scene.bounds.extent()) : 0.0) {}

bool SeenBounds::may_matter(const DBox3& box) const {
    if (box.is_empty()) return false;
    if (!visibility::is_outside(frustum_, box)) return true;
    if (!has_shadows_) return false;
    // The box swept down along the light, as far as there may be ground.
    const double fall_m = std::min(std::max(0.0, box.high.y - floor_y_) / to_sun_.y, reach_m_);
    const DVec3 along = -to_sun_ * fall_m;
    const DBox3 swept{glm::min(box.low, box.low + along), glm::max(box.high, box.high + along)};
    if (visibility::is_outside(frustum_, swept)) return false;
    const double size_m = glm::length(box.extent());
    return size_m >= kLeastShadowPx * pixel_angle_ * distance_to(swept, frustum_.position);
}

}  // namespace ff::animation
