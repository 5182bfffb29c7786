#pragma once

#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "engine/math/types.h"

namespace ff {

/// An axis-aligned box; empty (low > high) until something is added.
template <class V>
struct Box {
    using Scalar = typename V::value_type;
    V low{std::numeric_limits<Scalar>::infinity()};
    V high{-std::numeric_limits<Scalar>::infinity()};

    void add(const V& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    void add(const Box& other) {
        low = glm::min(low, other.low);
        high = glm::max(high, other.high);
    }
    [[nodiscard]] bool is_empty() const { return !(low.x <= high.x && low.y <= high.y && low.z <= high.z); }
    [[nodiscard]] V center() const { return (low + high) * Scalar(0.5); }
    [[nodiscard]] V extent() const { return high - low; }
};

using Box3 = Box<Vec3>;    ///< local: relative to a mesh's or cell's origin
using DBox3 = Box<DVec3>;  ///< world

/// Distance from a point to the nearest point of the box; 0 inside.
[[nodiscard]] inline double distance_to(const DBox3& box, const DVec3& p) {
    const DVec3 d = glm::max(glm::max(box.low - p, p - box.high), DVec3(0.0));
    return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

}  // namespace ff
