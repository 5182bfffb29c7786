#pragma once
// How wind moves leaves: their pictures are shifted within the cards that carry them, by a function of place and time
// alone. No triangle moves, so no hierarchy is refitted, and whoever finds or shades a pixel evaluates the same
// function.
//
//   shift(uv) = size * window(u) * window(v) * (wave_u, wave_v)
//   size      = amplitude in uv units, at most kMostLeafShift, times the gust there, fading out towards within_m
//   window    = 4 f (1 - f), f the place within the picture: its border stands still, so that neighbouring cards stay
//               joined, stems hold, and nothing is cut off or wraps round
//
// The same in shaders/leaf_sway.glsl and, for vectors, in leaf_sway-inl.h.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/math/types.h"

namespace ff {

/// The wind in leaves at a moment, seen from one eye. None where within_m is 0.
struct LeafSway {
    /// A plane wave: its phase at p is turns + dot(turns_per_m, p), p relative to the eye.
    struct Train {
        Vec3 turns_per_m{0.0f};
        float turns = 0.0f;  ///< at the eye, [-0.5, 0.5]
    };
    Train gust, along_u, along_v;
    float amplitude_m = 0.0f;  ///< largest shift, in the middle of a card
    float within_m = 0.0f;     ///< farther from the eye leaves stand still

    [[nodiscard]] bool is_none() const { return !(within_m > 0.0f); }
};

/// Pictures are shifted by no more than this share of themselves, so that what is shifted never leaves the card:
/// the window's slope is 4.
inline constexpr float kMostLeafShift = 0.1f;
/// Share of within_m over which the movement fades out.
inline constexpr float kLeafSwayFade = 0.4f;
/// Least strength of the gusts, and what they add to it.
inline constexpr float kGustMiddle = 0.65f, kGustSwing = 0.35f;

/// A sine made of parabolas, by turns: 0, 1, 0, -1 at 0, 1/4, 1/2, 3/4. Off a true one by 0.056 at most; its few
/// operations give the same number wherever they run.
[[nodiscard]] inline float turn_sine(float turns) {
    const float t = turns - std::floor(turns + 0.5f);
    return 8.0f * t * (1.0f - 2.0f * std::abs(t));
}

/// The same movement for places in other axes about the same eye.
/// @param axes  orthonormal, takes the new axes' places to the old ones'
[[nodiscard]] inline LeafSway in_axes(const LeafSway& sway, const Mat3& axes) {
    LeafSway out = sway;
    for (LeafSway::Train* train : {&out.gust, &out.along_u, &out.along_v})
        train->turns_per_m = train->turns_per_m * axes;
    return out;
}

/// What to add to a texture coordinate. Any float is answered.
/// @param uv        where a card is hit
/// @param uv_per_m  of its triangle: root of texture area over area
/// @param from_eye  the hit relative to the eye, metres, in the sway's axes
[[nodiscard]] inline Vec2 leaf_shift(const LeafSway& sway, const Vec2& uv, float uv_per_m, const Vec3& from_eye) {
    const float distance = std::sqrt(glm::dot(from_eye, from_eye));
    const float fade = std::min((1.0f - distance / sway.within_m) * (1.0f / kLeafSwayFade), 1.0f);
    if (!(fade > 0.0f)) return Vec2(0.0f);
    const auto wave = [&](const LeafSway::Train& train) {
        return turn_sine(train.turns + glm::dot(train.turns_per_m, from_eye));
    };
    const auto window = [](float c) {
        const float f = c - std::floor(c);
        return 4.0f * f * (1.0f - f);
    };
    const float gust = kGustMiddle + kGustSwing * wave(sway.gust);
    const float size = fade * gust * std::min(sway.amplitude_m * uv_per_m, kMostLeafShift);
    const float shown = size * window(uv.x) * window(uv.y);
    return {shown * wave(sway.along_u), shown * wave(sway.along_v)};
}

}  // namespace ff
