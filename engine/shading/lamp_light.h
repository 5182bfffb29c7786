#pragma once
// Light of lamps: which of them a frame and a tile have to do with.

#include <array>
#include <cstdint>
#include <span>

#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/math/types.h"

namespace ff::shading {

/// A lit lamp as pixels see it.
struct LampLight {
    Vec3 position{0.0f};  ///< relative to the viewer, world axes, metres
    float radius_m = 1.0f;
    Vec3 strength{0.0f};  ///< linear RGB: times albedo and cosine over the square of the distance gives the lit colour
};

/// What a lumen does at a metre: so that 10 lux on a white surface show as half of white.
inline constexpr float kLitPerLumen = 0.05f / (4.0f * 3.14159265f);
/// Square of the distance below which a lamp's light grows no more, m^2.
inline constexpr float kLampCore = 0.05f;
/// Lamps of one tile. The ones beyond light nothing there, from the last of the frame's on.
inline constexpr int kMaxTileLamps = 64;

/// A lamp's light on a surface: strength / (d^2 + kLampCore) * (1 - (d / radius)^4)^2.
/// Based on: Karis, "Real Shading in Unreal Engine 4", SIGGRAPH 2013 course (the window).
[[nodiscard]] inline double lamp_falloff(double distance2, double radius_m) {
    const double share = distance2 / (radius_m * radius_m);
    const double window = share < 1.0 ? 1.0 - share * share : 0.0;
    return window * window / (distance2 + double(kLampCore));
}

/// The lamps that may reach a tile's pixels, by their index, in the frame's order.
/// @param tile  pixels that are wanted; sky is passed over
/// @return how many of `out` were written
int find_tile_lamps(std::span<const LampLight> lamps, const PinholeView& view,
                    const farfield::VisibilityBuffer& visibility, const farfield::TileRequest& tile,
                    std::array<std::uint16_t, kMaxTileLamps>& out);

}  // namespace ff::shading
