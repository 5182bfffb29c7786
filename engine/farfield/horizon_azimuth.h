#pragma once
// How directions map to the columns of a HorizonMap.
//
// A column is an interval of azimuth, clockwise from north (-z) over east (+x). Instead of atan2 a rational quasi-angle
// is used: within an octant, with t = min(|x|, |z|) / max(|x|, |z|),
//   turn = t * (1/8 + k * (1 - t)),  k = 0.273 / (2 pi)
// It is monotone and continuous all the way round, within 0.0006 turns of the true angle, and what counts here is only
// that everybody uses the same one. Opposite directions differ by half a turn.
//
// Based on: Rajan, Wang, Inkol, Joyal, "Efficient Approximations for the Arctangent Function", IEEE SPM 2006, eq. (7).

#include <algorithm>
#include <cmath>

#include "engine/math/types.h"

namespace ff::farfield {

inline constexpr float kQuasiAngleBend = 0.0434493f;  ///< 0.273 / (2 pi)

/// Quasi-azimuth of a horizontal direction in turns, [0, 1]; 0 and 1 are north. The zero direction is north.
[[nodiscard]] inline float azimuth_turn(float x, float z) {
    const float ax = std::abs(x), az = std::abs(z);
    const float t = std::min(ax, az) / std::max(std::max(ax, az), 1e-37f);
    float turn = t * (0.125f + kQuasiAngleBend * (1.0f - t));
    if (ax > az) turn = 0.25f - turn;
    if (z > 0.0f) turn = 0.5f - turn;
    return x < 0.0f ? 1.0f - turn : turn;
}

/// The unit direction (x, z) at a turn; any real number. The inverse of azimuth_turn, in double.
inline void azimuth_direction(double turn, double& x, double& z) {
    turn -= std::floor(turn);
    const bool west = turn > 0.5;
    if (west) turn = 1.0 - turn;
    const bool south = turn > 0.25;
    if (south) turn = 0.5 - turn;
    const bool steep = turn > 0.125;  // nearer to the east-west axis
    if (steep) turn = 0.25 - turn;
    const double k = double(kQuasiAngleBend), b = 0.125 + k;
    const double t = (b - std::sqrt(std::max(0.0, b * b - 4.0 * k * turn))) / (2.0 * k);
    const double scale = 1.0 / std::sqrt(1.0 + t * t);
    x = (steep ? 1.0 : t) * scale;
    z = -(steep ? t : 1.0) * scale;
    if (south) z = -z;
    if (west) x = -x;
}

}  // namespace ff::farfield
