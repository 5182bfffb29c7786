#pragma once
// FLIP: the difference that a person sees who switches between two images.
//
// Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating
// Images", Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2), HPG 2020: the version for
// images of low dynamic range.

#include "tools/accuracy/planes.h"

namespace ff::accuracy {

/// Pixels a degree of the eye: a 0.7 m wide monitor of 3,840 pixels seen from 0.7 m, as in the paper.
inline constexpr double kPixelsPerDegree = 67.0;

/// Compares images of one size; keeps its memory from call to call. Threads: one caller, parallel inside.
class Flip {
  public:
    explicit Flip(double pixels_per_degree = kPixelsPerDegree);

    /// @return mean of the map
    double compare(const shading::Image& reference, const shading::Image& test);
    /// The last comparison's error per pixel, [0, 1].
    [[nodiscard]] const Plane& map() const { return map_; }

  private:
    struct Filtered {
        Plane lightness, a, b;   ///< L*a*b*, Hunt-adjusted, after the contrast sensitivity of the eye
        Plane edge_x, edge_y;    ///< first derivatives of the lightness
        Plane point_x, point_y;  ///< second ones
    };
    void look_at(const shading::Image& image, Filtered& out);

    // Contrast sensitivity of the three channels; that of blue-yellow is a sum of two Gaussians.
    std::vector<float> achromatic_, red_green_, blue_yellow_[2];
    float blue_yellow_share_[2];
    std::vector<float> feature_, feature_edge_, feature_point_;  ///< Gaussian, its first and second derivative
    float max_color_error_;
    Filtered reference_, test_;
    Plane y_, cx_, cz_, scratch_, sum_, map_;
};

}  // namespace ff::accuracy
