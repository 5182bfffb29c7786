#pragma once

#include <algorithm>
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

/// Whether the segment from `from` to `from + along` meets the box, its surface included.
[[nodiscard]] inline bool meets_segment(const DBox3& box, const DVec3& from, const DVec3& along) {
    double enter = 0.0, leave = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = box.low[axis] - from[axis], high = box.high[axis] - from[axis];
        if (along[axis] == 0.0) {
            if (low > 0.0 || high < 0.0) return false;
            continue;
        }
        const double a = low / along[axis], b = high / along[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
}

}  // namespace ff
