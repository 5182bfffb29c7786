#pragma once

#include <array>
#include <string_view>

#include "engine/debug/overlay.h"
#include "engine/frame/renderer.h"

namespace ff::tool {

enum class DebugView { none, sources, age, light, border, causes, work };
inline constexpr std::array<std::string_view, 7> kDebugViewNames{"none",   "sources", "age", "light",
                                                                 "border", "causes",  "work"};

/// Draws a debug view of the renderer's last frame over or instead of its picture: where each pixel came from, how old
/// its panorama texel or its sunlight is, the border of the near field, the causes of a reprojected frame's pixels, or
/// what each tile costs the tile caster.
void draw_debug_view(DebugView view, const frame::Renderer& renderer, frame::Casters& casters, shading::Image& image);

/// The last frame's statistics as the overlay's table; the strings are reused.
void fill_overlay(const frame::Renderer& renderer, debug::OverlayData& data);

}  // namespace ff::tool
