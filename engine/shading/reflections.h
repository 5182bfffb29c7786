#pragma once
// What mirrors show of the world, as shading reads it: an image of less than the frame's size, whose pixels lie on
// those of the mirrors that show them. Based on: P0 section 9.4, few rays for an effect that needs no high accuracy.

#include <algorithm>

#include "engine/shading/shading_pass.h"

namespace ff::shading {

/// Alpha of a pixel of the image: nobody asked for it; the ray leaves the world; it meets a surface.
inline constexpr std::uint32_t kReflectsUnknown = 0, kReflectsSky = 128, kReflectsSurface = 255;

/// Reflectance from which on a mirror shows the world instead of the sky alone, and fully.
inline constexpr float kLeastReflectance = 0.05f, kFullReflectance = 0.10f;

/// How much of the world a mirror shows, [0, 1].
/// @param facing  cosine between its normal and the viewer
/// @param f0      reflectance of who looks straight at it
[[nodiscard]] inline float reflection_share(float facing, float f0) {
    const float grazing = 1.0f - facing, grazing2 = grazing * grazing;
    const float reflectance = f0 + (1.0f - f0) * grazing2 * grazing2 * grazing;
    return std::clamp((reflectance - kLeastReflectance) / (kFullReflectance - kLeastReflectance), 0.0f, 1.0f);
}

struct Reflections {
    const Image& image;     ///< at least 2 x 2
    int left = 0, top = 0;  ///< pixel of the view on whose corner the image's first has its own; multiples of step
    const float* depth;     ///< as the image's pixels: along the view's rays, by way of the mirror; +inf for sky
    int step = 1;           ///< pixels of the view along a side of one of these
    float within_m = 0.0f;  ///< depth at which mirrors but water show nothing any more; from half of it on they fade
};

}  // namespace ff::shading
