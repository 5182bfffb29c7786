#pragma once
// What every entry of the module does with numbers that come from outside.

#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "engine/core/result.h"
#include "engine/math/types.h"
#include "engine/physics/types.h"

namespace ff::physics {

/// Nothing is farther from the world's origin than this, metres: where a double still tells a micrometre.
inline constexpr double kMaxCoordinate_m = 1e9;
inline constexpr float kMaxSpeed_m_s = 1e6f;

/// Refuses NaN, too.
[[nodiscard]] inline Status check_range(const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return {};
    return usage_error(fmt::format("{} is {}; expected {} to {}", name, value, low, high));
}
template <class Vector>
[[nodiscard]] Status check_vector(const char* name, const Vector& v, double limit) {
    for (int axis = 0; axis < 3; ++axis) FF_TRY(check_range(name, double(v[axis]), -limit, limit));
    return {};
}
/// Also makes the rotation unit. Refuses one that is far from it.
[[nodiscard]] inline Status check_pose(Pose& pose) {
    FF_TRY(check_vector("position", pose.position, kMaxCoordinate_m));
    const double length2 = double(glm::dot(pose.rotation, pose.rotation));
    FF_TRY(check_range("squared length of rotation", length2, 0.25, 4.0));
    // A unit one is left alone, bit for bit: a pose that was read is the pose that is given back.
    if (std::abs(length2 - 1.0) > 1e-6) pose.rotation = glm::normalize(pose.rotation);
    return {};
}

}  // namespace ff::physics
