#pragma once
// Mirrors are at rest while what they show stands still, and then have the colour of an earlier frame; waves move, and
// what is mirrored may.

#include <cstdint>
#include <span>

#include "engine/farfield/pixel_mask.h"
#include "engine/frame/plan.h"
#include "engine/scene/static_scene.h"

namespace ff::frame {

struct FrameHistory;

/// Finds what the mirrors of a frame may show of what moves.
/// @param history  its `mirrored` is written; `moving` holds what moves in this frame
void find_mirrored(const FramePlan& plan, FrameHistory& history);

/// Whether the frame may have mirrors that are not at rest.
[[nodiscard]] bool has_restless_mirrors(const FramePlan& plan, const FrameHistory& history);

/// Takes their pixels out of a mask.
/// @param history  find_mirrored() was called for the frame, and its visibility answers those of the mask's pixels that
///                 `named` has, too
/// @param named    optional: pixels that may show one; else all of the mask's may
void take_out_restless_mirrors(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
                               const farfield::PixelMask* named, farfield::PixelMask& mask);

/// Leaves in a mask only mirrors that are at rest.
/// @param history  likewise
void keep_resting_mirrors(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
                          farfield::PixelMask& mask);

}  // namespace ff::frame
