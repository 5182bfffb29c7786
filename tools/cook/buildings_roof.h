#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "tools/cook/buildings_footprint.h"
#include "tools/cook/mesh_builder.h"

namespace ff::cook {

struct RoofLook {
    std::uint32_t roof = 0, wall = 0, trim = 0;  ///< materials
    std::uint32_t roof_color = kWhite, wall_color = kWhite, trim_color = kWhite;
    double tile_m = 3.0;
    double rise = 0.45;       ///< height of the ridge over half the span
    double overhang_m = 0.0;  ///< of the eaves beyond the walls
};

/// A level roof over an outline with holes.
void add_flat_roof(MeshBuilder& mesh, const Footprint& footprint, double y, const RoofLook& look);

/// Roofs over four corners, counter-clockwise, convex. The ridge runs along the longer side.
void add_gabled_roof(MeshBuilder& mesh, const std::array<DVec2, 4>& corners, double y, const RoofLook& look);
void add_hipped_roof(MeshBuilder& mesh, const std::array<DVec2, 4>& corners, double y, const RoofLook& look);

/// A flat roof behind a parapet: coping, inner faces, and the roof below it.
void add_parapet_roof(MeshBuilder& mesh, const std::array<DVec2, 4>& corners, double y, double parapet_m,
                      const RoofLook& look);

/// Height of the ridge above the eaves for these corners.
[[nodiscard]] double ridge_rise(const std::array<DVec2, 4>& corners, const RoofLook& look);

/// The corners turned so that side 0-1 is one of the longer pair.
[[nodiscard]] std::array<DVec2, 4> long_side_first(const std::array<DVec2, 4>& corners);

/// The corners moved outwards by `distance_m` (inwards where negative).
[[nodiscard]] std::array<DVec2, 4> offset_corners(const std::array<DVec2, 4>& corners, double distance_m);

[[nodiscard]] bool is_convex_quad(const Footprint& footprint);

}  // namespace ff::cook
