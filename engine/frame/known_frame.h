#pragma once

#include "engine/frame/run_passes.h"

namespace ff::frame {

/// Mode irsa: an exact cast that no time counts tells each pixel's primitive; what counts is one intersection a pixel
/// (P3 7.3).
void confirm_known_primitives(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats);

}  // namespace ff::frame
