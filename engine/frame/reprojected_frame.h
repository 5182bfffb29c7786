#pragma once

#include "engine/frame/run_passes.h"

namespace ff::frame {

/// Mode reproject (P3): the last frame's hits are reprojected and verified by one intersection each; casters answer the
/// rest.
void reproject_or_cast(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats);

}  // namespace ff::frame
