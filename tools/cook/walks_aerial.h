#pragma once
// Walks that leave the ground, and walks around things that have none.

#include <vector>

#include "tools/cook/ground_map.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// What a circle around the scene is drawn around.
struct SceneCircle {
    DVec3 center{0.0};    ///< looked at
    double radius_m = 5;  ///< of the scene's dense part, horizontally
};

/// The whole scene if it is at most 600 m wide, else its dense part.
/// @param ground_y  height of the ground in the dense part
[[nodiscard]] SceneCircle scene_circle(const StaticTriangles& triangles, const DensityMap& density, double ground_y);

/// Once around, looking in, above everything below the circle.
[[nodiscard]] std::vector<WalkFrame> orbit(const SceneCircle& circle, const DensityMap& density, int frames);

/// From eye height above a place straight up until there is room, once around in a view over the scene, and back down:
/// below 30 m/s, never through anything.
[[nodiscard]] std::vector<WalkFrame> fly_over(const GroundMap& map, std::uint32_t start, double yaw_deg,
                                              const SceneCircle& circle, int frames);

/// A thing without ground, looked at from all sides.
struct ObjectView {
    DVec3 center{0.0};
    double distance_m = 10;
    double eye_y = 1.7;
};
[[nodiscard]] ObjectView object_view(const DBox3& bounds);

/// Part of a circle around an object, from the south to the east and on, at most once around.
/// @param rise_m  how much higher than the eye the middle frame is
[[nodiscard]] std::vector<WalkFrame> walk_around(const ObjectView& view, double speed_m_s, double rise_m, int frames);

}  // namespace ff::cook
