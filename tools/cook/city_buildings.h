#pragma once
// The elements of which a city's buildings are put together: storeyed bodies over convex quads, with their roofs.

#include <array>
#include <cstdint>

#include "tools/cook/buildings_facade.h"
#include "tools/cook/buildings_roof.h"
#include "tools/cook/city_block.h"

namespace ff::cook::city {

enum class WallKind : std::uint8_t { brick, plaster, stone, concrete, curtain };

/// A wall's look for a building: materials, colours and proportions by kind and seed.
[[nodiscard]] FacadeStyle city_facade(const BlockWriter& writer, WallKind kind, std::uint64_t seed);
/// The same wall with less on it, for courtyards and high up.
[[nodiscard]] FacadeStyle plainer(const FacadeStyle& style);
[[nodiscard]] RoofLook city_roof(const BlockWriter& writer, const FacadeStyle& style, std::uint64_t seed, bool sloped);

enum class SideKind : std::uint8_t { front, back, party };

struct BodySide {
    SideKind kind = SideKind::front;
    double from_y = 0;  ///< of a party wall: it is built from here up, if at all
    bool door = false;
};

struct Body {
    Quad corners{};
    double foot_y = 0;   ///< walls begin here, below the ground or the roof below
    double floor_y = 0;  ///< storeys begin here
    double top_y = 0;
    std::array<BodySide, 4> sides{};
};

/// Walls only. Above `plain_from_y` they carry less.
void add_body_walls(BlockWriter& writer, const Body& body, const FacadeStyle& style, std::uint64_t seed,
                    double plain_from_y = 1e9);

/// Boxes, ducts and masts on a flat roof whose floor is at `y`.
void add_roof_plant(BlockWriter& writer, const Quad& roof, double y, std::uint64_t seed, bool mast);

/// A chimney through a roof. @param ridge_y  it rises a little above
void add_chimney(BlockWriter& writer, const DVec2& p, const DVec2& axis, double from_y, double ridge_y,
                 std::uint32_t color);

/// Dormers along both slopes of a gabled or hipped roof without overhang.
void add_dormers(BlockWriter& writer, const Quad& corners, double eaves_y, const RoofLook& roof,
                 const FacadeStyle& style, double spacing_m, double margin_m);

/// Lowest and highest ground under a quad's corners.
[[nodiscard]] std::array<double, 2> ground_range(const BlockWriter& writer, const Quad& quad);

}  // namespace ff::cook::city
