#pragma once

#include "engine/frame/run_passes.h"

namespace ff::frame {

/// How the pixels of a view are shaded this frame; finds the lamps that light it.
/// @param sun_seen, reflections  as ShadeSettings has them
/// @param lights  what the settings point at, made anew
[[nodiscard]] shading::ShadeSettings shade_settings(const FramePlan& plan, const Tools& tools, const PinholeView& view,
                                                    const std::uint8_t* sun_seen, ViewLights& lights, FrameStats& stats,
                                                    const shading::Reflections* reflections = nullptr);

}  // namespace ff::frame
