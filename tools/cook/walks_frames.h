#pragma once
// Frames of walks from positions: directions of view without jumps, and rounding.

#include <vector>

#include "tools/cook/walks_route.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

inline constexpr double kEyeHeight_m = 1.7;

/// Turns angles into a continuous sequence and evens it out until no step is larger than `most_deg`; the first and
/// last values may move, too.
void smooth_angles(std::vector<double>& angles_deg, double most_deg);

/// A walker at constant speed along a route at eye height, looking ahead; back and forth where the route is too short.
/// @param start_m   along the route
/// @param speed_m_s at 30 frames a second
/// @param look_m    how far ahead on the route the eye looks
[[nodiscard]] std::vector<WalkFrame> walk_along(const WalkRoute& route, double start_m, double speed_m_s, double look_m,
                                                int frames);

/// Looks from each position at a point. Yaw and pitch only.
void look_at(std::vector<WalkFrame>& frames, const DVec3& target);

/// Whole micrometres and microdegrees, yaw in [0, 360): the same on every machine.
void round_frames(std::vector<WalkFrame>& frames);

}  // namespace ff::cook
