#pragma once
// Errors of pictures beside FLIP's: structural similarity, flicker, and what lies where it should not.

#include "engine/farfield/visibility_buffer.h"
#include "engine/scene/static_scene.h"
#include "tools/accuracy/planes.h"

namespace ff::accuracy {

/// Mean structural similarity of two images' luma, (-1, 1]; 1: equal. Gaussian window of 11 pixels, sigma 1.5.
/// Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE
/// Transactions on Image Processing 13(4), 2004.
[[nodiscard]] double structural_similarity(const shading::Image& a, const shading::Image& b);

/// How differently two sequences change from one frame to the next: root mean square over pixels and channels of
/// (test - test before) - (reference - reference before), in levels of 255. 0 where the reference flickers as well.
[[nodiscard]] double flicker(const shading::Image& before, const shading::Image& test,
                             const shading::Image& reference_before, const shading::Image& reference);

/// What is seen where, against the truth.
struct VisibilityError {
    double wrong_primitives = 0.0;  ///< share of pixels that show another primitive, [0, 1]
    /// The 99th percentile over all pixels of how many pixels off the same primitive is really seen; kFarPx where it
    /// is nowhere near.
    double displacement_px = 0.0;
};
inline constexpr int kFarPx = 8;

/// Pixels whose depths agree to 1e-4 of the distance count as equal: coincident surfaces. Both of one size.
[[nodiscard]] VisibilityError compare_visibility(const farfield::VisibilityBuffer& test,
                                                 const farfield::VisibilityBuffer& exact);

}  // namespace ff::accuracy
