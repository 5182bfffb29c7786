#pragma once

#include <array>

#include "engine/math/bounds.h"
#include "engine/math/camera.h"

namespace ff::visibility {

/// What a pinhole view can see: inside where dot(normal, p - position) >= 0 for all planes. No far plane.
struct Frustum {
    static constexpr int kPlanes = 5;      ///< left, right, bottom, top, and the one through the eye
    std::array<DVec3, kPlanes> normals{};  ///< unit, world axes
    WorldPos position{0.0};
};

[[nodiscard]] Frustum make_frustum(const PinholeView& view);

/// Whether some plane has all of the box on its outer side. In double: the reference for what culls in float.
[[nodiscard]] bool is_outside(const Frustum& frustum, const DBox3& box);

}  // namespace ff::visibility
