#pragma once
// A wall with storeys and bays: windows set back behind their reveals, sills, mullions, ledges, balconies, doors and
// shop fronts, all as geometry, by rule.

#include <cstdint>

#include "tools/cook/buildings_footprint.h"
#include "tools/cook/mesh_builder.h"

namespace ff::cook {

/// A straight piece of wall, seen from outside with p on the left.
struct WallSpan {
    DVec2 p{0.0}, q{0.0};   ///< plan
    double y0 = 0, y1 = 0;  ///< foot and top
    double ground_y = 0;    ///< where storeys begin: at or above y0
};

struct FacadeStyle {
    std::uint32_t wall = 0, glass = 0, trim = 0, door = 0;  ///< materials
    std::uint32_t wall_color = kWhite, glass_color = kWhite, trim_color = kWhite, door_color = kWhite;
    DVec2 wall_tile_m{4.0, 4.0};
    double storey_m = 3.2, ground_storey_m = 3.6;
    double bay_m = 3.0;          ///< aimed at; bays share the wall's length evenly
    double window_width = 0.45;  ///< of the bay
    double window_height = 0.5;  ///< of the storey
    double sill = 0.28;          ///< of the storey, below the window
    double recess_m = 0.15;      ///< how far the glass lies behind the wall. > 0
    bool sills = true;           ///< a ledge below each window
    bool mullions = true;        ///< a bar down and one across each window
    bool frames = false;         ///< a raised surround
    bool ledges = false;         ///< a band between the storeys
    bool cornice = true;         ///< a wider band at the top
    bool shops = false;          ///< wide panes on the ground floor
    double balcony_share = 0.0;  ///< of the upper storeys' bays. [0, 1]
    bool pilasters = false;      ///< ribs between the bays, over the whole height
};

/// Appends a wall. @param seed  decides where doors and balconies go.
/// @param door  puts a door into the middle bay of the ground floor
void add_facade(MeshBuilder& mesh, const WallSpan& span, const FacadeStyle& style, std::uint64_t seed, bool door);

/// A wall without openings.
void add_blank_wall(MeshBuilder& mesh, const WallSpan& span, const FacadeStyle& style);

/// An upright box over a rectangle of the plan turned by its axis; no bottom.
/// @param axis  unit; @param half  half extents along the axis and to its left
void add_box(MeshBuilder& mesh, const DVec2& center, const DVec2& axis, const DVec2& half, double y0, double y1,
             std::uint32_t material, std::uint32_t color, double tile_m = 4.0);

/// A number in [0, 1) from a seed and a place; the same on every machine.
[[nodiscard]] double hash_unit(std::uint64_t seed, std::uint64_t a, std::uint64_t b = 0, std::uint64_t c = 0);
[[nodiscard]] std::uint64_t hash_mix(std::uint64_t seed, std::uint64_t a, std::uint64_t b = 0, std::uint64_t c = 0);

}  // namespace ff::cook
