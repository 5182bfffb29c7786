#pragma once
// Distances of upright or leaning capsules from triangles and from each other, and when a moving one meets them. In
// double: a controller that stands within micrometres of a surface for hours must not creep.
//
// Based on: Ericson, "Real-Time Collision Detection", 2005, chapter 5 (closest points); Mirtich, "Impulse-based Dynamic
// Simulation of Rigid Body Systems", PhD thesis, Berkeley 1996 (conservative advancement).

#include <optional>

#include "engine/math/types.h"

namespace ff::physics {

/// A segment; with a radius around it, a capsule. a == b: a sphere.
struct Segment {
    DVec3 a{0.0}, b{0.0};
};
struct Triangle {
    DVec3 a{0.0}, b{0.0}, c{0.0};
};

/// The nearest points of two things, and how far apart they are; 0 where they cross.
struct Nearest {
    double distance = 0.0;
    DVec3 on_segment{0.0};
    DVec3 on_other{0.0};
};

[[nodiscard]] DVec3 nearest_on_segment(const Segment& segment, const DVec3& p);
[[nodiscard]] DVec3 nearest_on_triangle(const Triangle& triangle, const DVec3& p);
[[nodiscard]] Nearest nearest(const Segment& segment, const Segment& other);
[[nodiscard]] Nearest nearest(const Segment& segment, const Triangle& triangle);

/// Unit normal by the corners' order; 0 for a triangle without an area.
[[nodiscard]] DVec3 normal_of(const Triangle& triangle);

struct Touch {
    double time = 0.0;  ///< part of the way, [0, 1]
    DVec3 normal{0.0};  ///< unit, from the other to the capsule
    DVec3 point{0.0};   ///< on the other
};

/// A sweep stops where the gap is not more than this, metres, and the capsule comes nearer.
inline constexpr double kTouchGap = 1e-6;

/// When a capsule that moves by `along` first comes within `radius` of what does not move; nothing where it does not
/// before `limit` (part of the way), or only moves away from what it already touches.
/// Never late: each step goes no farther than the separating plane allows. One that does not converge counts as a touch
/// where it got to.
/// @param radius  of the capsule, and of the other segment together
/// @param leave_crossed  what the capsule's core crosses from the start is left out, instead of stopping it there
[[nodiscard]] std::optional<Touch> touch(const Segment& capsule, double radius, const DVec3& along,
                                         const Triangle& triangle, double limit, bool leave_crossed = false);
[[nodiscard]] std::optional<Touch> touch(const Segment& capsule, double radius, const DVec3& along,
                                         const Segment& other, double limit, bool leave_crossed = false);

}  // namespace ff::physics
