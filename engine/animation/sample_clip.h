#pragma once
// A clip at a point in time.

#include "engine/animation/pose.h"

namespace ff::animation {

/// What happens when a clip has played through.
enum class PlayMode : std::uint8_t {
    loop,       ///< from the start again
    once,       ///< its end stays
    ping_pong,  ///< backwards, and so on
};

/// The clip's own time for a time since it began, which may be negative: [0, duration].
[[nodiscard]] float clip_time(const scene::Clip& clip, double time_s, PlayMode mode);

/// Writes what the clip says of its joints at a time; what it says nothing of stays.
/// Between keys: STEP the earlier, LINEAR straight, for rotations along the great circle and the shorter way,
/// CUBICSPLINE by glTF's Hermite spline, rotations normalised. Outside the keys their ends.
/// @param time_s  within the clip, as clip_time gives
/// @param pose    of as many joints as the clip's skeleton
/// Allocates nothing. Source: Khronos, "glTF 2.0 Specification", appendix C.
void sample_clip(const scene::Clip& clip, float time_s, Pose& pose);

}  // namespace ff::animation
