#pragma once
// Images as planes of floats, and the separable filters that image metrics are made of.

#include <span>
#include <vector>

#include "engine/shading/shading_pass.h"

namespace ff::accuracy {

/// One channel of an image, rows of `width` floats.
struct Plane {
    int width = 0, height = 0;
    std::vector<float> values;

    void resize(int new_width, int new_height);
    [[nodiscard]] float* row(int y) { return values.data() + std::size_t(y) * std::size_t(width); }
    [[nodiscard]] const float* row(int y) const { return values.data() + std::size_t(y) * std::size_t(width); }
};

/// out = in filtered by `across` in x, then by `down` in y. Beyond the border stands its nearest pixel.
/// @param across, down  [2 r + 1] taps each, the middle one at the pixel; any r
/// @param scratch       any size
void filter(const Plane& in, std::span<const float> across, std::span<const float> down, Plane& scratch, Plane& out);

/// Taps of a Gaussian, sum 1. @param sigma  pixels, > 0  @param radius  pixels, >= 0
[[nodiscard]] std::vector<float> gaussian_taps(double sigma, int radius);

/// sRGB channel values 0..255 to linear [0, 1].
[[nodiscard]] std::span<const float, 256> linear_of_srgb();

}  // namespace ff::accuracy
