#pragma once
// The reprojection of reproject.h once more, point by point and pixel by pixel in double: what the fast one is tested
// against.

#include <vector>

#include "engine/farfield/reproject.h"

namespace ff::farfield {

/// Answers what Reprojection::reproject() and verify() answer, up to the rounding of points that land on the border of
/// two pixels and of rays that meet an edge.
/// @param last    not `out`
/// @param out     verified and background pixels are written
/// @return the cause of each pixel, row by row of view.width; empty where nothing may be reprojected
std::vector<PixelCause> reproject_reference(const scene::StaticScene& scene, const PinholeView& last_view,
                                            const VisibilityBuffer& last, const PinholeView& view,
                                            const ReprojectSettings& settings, std::uint64_t frame_number,
                                            VisibilityBuffer& out);

/// Where a pixel's ray meets a triangle of a static instance: depth along the view axis; +inf where it does not, or
/// where the triangle is see-through.
/// @param slack  barycentrics down to -slack count as inside
[[nodiscard]] double intersect_primitive(const scene::StaticScene& scene, const PinholeView& view, int x, int y,
                                         std::uint32_t instance, std::uint32_t triangle, double slack = 0.0);

}  // namespace ff::farfield
