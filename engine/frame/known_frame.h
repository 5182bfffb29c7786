#pragma once

#include "engine/frame/run_passes.h"

namespace ff::frame {

/// Mode irsa: an exact cast that no time counts tells each pixel's primitive; what counts is one intersection a pixel
/// and the shading (P3 7.3).
void draw_known_frame(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
                      FrameStats& stats);

}  // namespace ff::frame
