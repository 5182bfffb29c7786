#pragma once
// Outlines of buildings on the ground plane, and their triangles.

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/math/types.h"

namespace ff::cook {

using DVec2 = glm::dvec2;

/// A point of the plan, (east, north) metres: mathematical orientation. The world has z = -north.
[[nodiscard]] inline DVec3 world_from_plan(const DVec2& plan, double y) {
    return {plan.x, y, -plan.y};
}

/// A ring's first point is not repeated at its end.
using Ring = std::vector<DVec2>;

/// The outer ring runs counter-clockwise seen from above, holes clockwise.
struct Footprint {
    Ring outer;
    std::vector<Ring> holes;
    double height_m = 0;  ///< of the walls' top above the ground
    double base_m = 0;    ///< of the walls' foot above the ground
    std::string name;     ///< for messages
};

/// Square metres, positive counter-clockwise.
[[nodiscard]] double signed_area(std::span<const DVec2> ring);

[[nodiscard]] bool contains(std::span<const DVec2> ring, const DVec2& point);
[[nodiscard]] bool contains(const Footprint& footprint, const DVec2& point);

/// Removes repeated and collinear points, and turns the ring counter-clockwise (or clockwise). Nothing is left of a
/// ring without area.
void normalize_ring(Ring& ring, bool counter_clockwise);

/// Triangulates a polygon with holes by ear clipping, holes joined to the outer ring by bridges.
/// @return  index triples into outer followed by the holes' points in order; counter-clockwise.
/// Never fails: where a broken outline leaves no ear, the least bad corner is cut off.
/// Based on: Held, "FIST: Fast Industrial-Strength Triangulation of Polygons", Algorithmica 30, 2001;
///   bridges as in Eberly, "Triangulation by Ear Clipping", 2002.
[[nodiscard]] std::vector<std::uint32_t> triangulate(const Ring& outer, std::span<const Ring> holes);

}  // namespace ff::cook
