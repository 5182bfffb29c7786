#pragma once

#include "engine/shading/shading_pass.h"

namespace ff::shading {

/// The difference of two images of one size, over their 8-bit sRGB channels.
struct ImageDifference {
    double psnr_db = 0.0;       ///< 99 where they are equal
    double wrong_pixels = 0.0;  ///< share of pixels off by more than the tolerated levels in some channel, [0, 1]
};

/// @param tolerated_levels  of 255: what a pixel's channel may be off by before it counts as wrong
[[nodiscard]] ImageDifference compare_images(const Image& a, const Image& b, int tolerated_levels);

}  // namespace ff::shading
