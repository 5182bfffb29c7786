#pragma once

#include <cstdint>
#include <span>

#include "engine/shading/shading_pass.h"

namespace ff::shading {

/// What the shading model says of one pixel, in plain scalar double: the yardstick of the fast pass and of the GLSL.
/// @param instance, triangle, depth  as in the visibility buffer
/// @param settings  sun_seen is read at the pixel of a buffer of the view's size
/// @return sRGB-encoded RGB in [0, 1], not rounded.
/// Differs from shade_tiles by at most 2/255 except where the two choose different mip levels, see
/// tests/shading/shading_test.cpp.
[[nodiscard]] Vec3 shade_reference(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                                   const PinholeView& view, int x, int y, std::uint32_t instance,
                                   std::uint32_t triangle, float depth, const ShadeSettings& settings);

/// log2 of the texels (of level 0) under one pixel's side, before rounding to a level: the mip level is this, rounded
/// and clamped. NaN for sky and untextured triangles.
[[nodiscard]] double reference_lod(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                                   const PinholeView& view, int x, int y, std::uint32_t instance,
                                   std::uint32_t triangle);

}  // namespace ff::shading
