#pragma once
// The vector types of the engine and its space conventions (design.md section 3): right-handed, Y up, metres, radians.
// Names of matrices read to_from: world_from_camera * p_camera = p_world.

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace ff {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using Mat3 = glm::mat3;
using Mat4 = glm::mat4;
using DVec3 = glm::dvec3;
using DMat3 = glm::dmat3;

/// A position in the world, in double: float32 would shimmer away from the origin.
using WorldPos = glm::dvec3;

inline constexpr double kPi = 3.14159265358979323846;
[[nodiscard]] constexpr double radians_of(double degrees) {
    return degrees * (kPi / 180.0);
}
[[nodiscard]] constexpr double degrees_of(double radians) {
    return radians * (180.0 / kPi);
}

}  // namespace ff
