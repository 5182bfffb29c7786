#pragma once
// The materials of a city, and the wall textures that come with it.

#include <cstdint>

#include "tools/cook/city.h"

namespace ff::cook::city {

/// Ids of WorldSource::materials. Vertex colours tint all of them.
struct CityMaterials {
    std::uint32_t brick = 0, plaster = 0, stone = 0, concrete = 0;  ///< walls; kWallTile metres a tile
    std::uint32_t plain = 0, metal = 0, glass = 0, curtain_glass = 0;
    std::uint32_t roof_red = 0, roof_dark = 0, roof_flat = 0;
    std::uint32_t asphalt = 0, pavement = 0, grass = 0, gravel = 0, leaves = 0;
};

inline constexpr double kWallTile = 3.2, kGroundTile = 4.0, kRoofTile = 3.0;  // metres

[[nodiscard]] CityMaterials add_city_materials(const CityTextures& textures, WorldSource& into);

}  // namespace ff::cook::city
