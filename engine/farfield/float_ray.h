#pragma once
// Rays made fit for float32, in which casters cut space. From far outside they begin where they reach the world: an
// origin 10,000 km away would be off by a metre. Denormal components become zeros: their products are not to be
// trusted.

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/farfield/ray_caster.h"
#include "engine/math/bounds.h"

namespace ff::farfield {

/// Moves the origin along its ray to the bounds (grown by a thousandth), where it lies farther outside of them than
/// they are large; rays from nearer, and those that are none, stay as they are.
/// @return lengths of the direction by which it was moved; +inf: the ray passes the bounds by
[[nodiscard]] inline double approach(const DBox3& bounds, Ray& ray) {
    const DVec3 size = bounds.high - bounds.low;
    const double reach = std::max({size.x, size.y, size.z});
    const DVec3 outside = glm::max(bounds.low - ray.origin, ray.origin - bounds.high);
    if (!(std::max({outside.x, outside.y, outside.z}) > reach) || !(reach >= 0.0)) return 0.0;
    constexpr double kInf = std::numeric_limits<double>::infinity();
    const double margin = 1e-3 * reach + 1e-6;
    double enter = 0.0, leave = kInf;
    for (int axis = 0; axis < 3; ++axis) {
        const auto step = double(ray.direction[axis]);
        const double low = bounds.low[axis] - margin - ray.origin[axis];
        const double high = bounds.high[axis] + margin - ray.origin[axis];
        if (step == 0.0) {
            if (low > 0.0 || high < 0.0) return kInf;
            continue;
        }
        enter = std::max(enter, std::min(low / step, high / step));
        leave = std::min(leave, std::max(low / step, high / step));
    }
    if (!(enter <= leave)) return kInf;
    ray.origin += enter * DVec3(ray.direction);
    return enter;
}

/// Components so small beside the largest that their products and inverses leave float's range become zero; no ray of
/// a world's size can tell.
[[nodiscard]] inline Vec3 without_denormals(Vec3 direction) {
    const Vec3 size = glm::abs(direction);
    const float least = 1e-25f * std::max(size.x, std::max(size.y, size.z));
    for (int axis = 0; axis < 3; ++axis)
        if (size[axis] < least) direction[axis] = 0.0f;
    return direction;
}

/// Casts a ray by cast(ray) -> RayHit once it is fit.
template <class Cast>
[[nodiscard]] RayHit cast_float_ray(const DBox3& bounds, Ray ray, Cast&& cast) {
    ray.direction = without_denormals(ray.direction);
    const double before = approach(bounds, ray);
    if (!std::isfinite(before)) return {kSkyInstance, 0, std::numeric_limits<float>::infinity()};
    RayHit hit = cast(ray);
    if (before > 0.0) hit.t = float(before + double(hit.t));
    return hit;
}

}  // namespace ff::farfield
