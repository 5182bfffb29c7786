#pragma once
// Waves of open water: a few trains of sines that run with the wind, as slopes of the surface.

#include <array>

#include "engine/math/types.h"
#include "engine/scene/environment.h"

namespace ff::shading {

/// One train, as pixels see it.
struct Wave {
    float x = 0.0f, z = 0.0f;  ///< wave vector, radians per metre
    float slope = 0.0f;        ///< largest
    float phase = 0.0f;        ///< at the eye, radians in [-pi, pi]
    float length_m = 1.0f;
};
using Waves = std::array<Wave, 5>;

/// A pixel wider than this share of a wave's length does not see it: it roughens the mirror instead.
inline constexpr float kWaveGone = 0.5f;
/// Waves fade from this share of the distance on at which there are none.
inline constexpr float kWavesFade = 0.6f;
/// Pixels are taken to be so many times as long as wide on water, which is seen at a grazing angle.
inline constexpr float kWaterStretch = 3.0f;

/// The waves at a moment. Deep water: a train's frequency is the root of gravity times its wave number.
/// Based on: Tessendorf, "Simulating Ocean Water", SIGGRAPH 1999 course (the dispersion).
/// @param time_s  the same time gives the same waves
[[nodiscard]] Waves make_waves(const WorldPos& eye, const scene::Weather& weather, double time_s);

}  // namespace ff::shading
