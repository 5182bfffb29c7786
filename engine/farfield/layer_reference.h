#pragma once
// The layers of one pixel the plain way: every blended triangle of every instance, in double. The yardstick of
// layer_finder.h.

#include <cstdint>
#include <vector>

#include "engine/farfield/layer_finder.h"

namespace ff::farfield {

struct ReferenceLayer {
    std::uint32_t instance = 0, triangle = 0;  ///< as in Layer
    double depth = 0.0;                        ///< along the view axis, metres
    double alpha = 0.0;                        ///< coverage, not rounded to 0 or 1
    double inside = 0.0;                       ///< least barycentric; on an edge 0
    double edge_m = 0.0;                       ///< the triangle's longest edge
    double height_m = 0.0;                     ///< its height above that, times which `inside` is a length
    double lod = 0.0;                          ///< log2 of the texels under the pixel's side; its mip is this, rounded
};

/// All that lie before a depth and within view.blend_within_m, in the order of their names. Those behind opaque ones
/// are among them, as are those that pass the pixel's ray at up to `slack` outside of an edge (in barycentrics).
[[nodiscard]] std::vector<ReferenceLayer> reference_layers(const LayerScene& scene, const PinholeView& view, int x,
                                                           int y, double visible_depth, double slack);

}  // namespace ff::farfield
