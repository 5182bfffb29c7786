#pragma once
// When float32 cannot tell on which side of a triangle's edge a ray passes, double does: shared by the grid's single
// rays and packets. So every decision has the sign of the exact one, no ray passes between neighbours or through a
// vertex that they share, and slivers are found where they are.

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/math/types.h"

namespace ff::farfield::grid {

/// Rounding of a triangle's signed volumes in float32, by the direction's largest component. Corners relative to the
/// ray's origin.
inline float volume_rounding(const Vec3& a, const Vec3& b, const Vec3& c) {
    constexpr float kRounding = 5e-7f;  // eight operations
    const auto products = [](const Vec3& p, const Vec3& q) {
        return p.x * (q.y + q.z) + p.y * (q.x + q.z) + p.z * (q.x + q.y);
    };
    const Vec3 x = glm::abs(a), y = glm::abs(b), z = glm::abs(c);
    return kRounding * std::max(products(x, y), std::max(products(y, z), products(z, x)));
}

/// Where a ray meets a triangle, in double; borders count.
/// @return t; below 0: it does not
inline double meet_in_double(const Vec3 (&corners)[3], const Vec3& origin, const Vec3& direction) {
    const DVec3 o(origin), d(direction);
    const DVec3 a = DVec3(corners[0]) - o, b = DVec3(corners[1]) - o, c = DVec3(corners[2]) - o;
    const double at_a = glm::dot(d, glm::cross(c, b)), at_b = glm::dot(d, glm::cross(a, c));
    const double at_c = glm::dot(d, glm::cross(b, a));
    const double least = std::min(at_a, std::min(at_b, at_c)), most = std::max(at_a, std::max(at_b, at_c));
    if (least < 0.0 && most > 0.0) return -1.0;
    const DVec3 normal = glm::cross(b - a, c - a);
    const double along = glm::dot(d, normal);
    return along == 0.0 ? -1.0 : glm::dot(a, normal) / along;
}

}  // namespace ff::farfield::grid
