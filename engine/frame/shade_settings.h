#pragma once

#include "engine/frame/run_passes.h"

namespace ff::frame {

/// How the pixels of a view are shaded this frame; finds the lamps that light it.
/// @param sun_seen, reflections  as ShadeSettings has them
/// @return points into the history: good until the next call
[[nodiscard]] shading::ShadeSettings shade_settings(const FramePlan& plan, const Tools& tools, const PinholeView& view,
                                                    const std::uint8_t* sun_seen, FrameHistory& history,
                                                    FrameStats& stats,
                                                    const shading::Reflections* reflections = nullptr);

}  // namespace ff::frame
