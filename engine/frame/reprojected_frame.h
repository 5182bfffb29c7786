#pragma once

#include "engine/frame/run_passes.h"

namespace ff::frame {

/// Mode reproject (P3): the last frame's hits are reprojected and verified by one intersection each, the ordinary
/// caster answers the rest, and all pixels are shaded anew.
void draw_reprojected_frame(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
                            FrameStats& stats);

}  // namespace ff::frame
