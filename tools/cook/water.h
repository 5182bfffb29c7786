#pragma once
// Open water: level sheets, and the beds that are dug for them.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/math/types.h"
#include "tools/cook/buildings_footprint.h"
#include "tools/cook/terrain.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

struct WaterDescription {
    double level_m = 0;
    std::vector<DVec2> outline;       ///< x, z, at least three, either way round; empty: wherever the ground is lower
    std::optional<double> depth_m;    ///< of a bed that is dug within the outline; none: the ground stays
    Vec3 color{0.05f, 0.12f, 0.16f};  ///< linear, where the bed is not seen
    Vec3 bed_color{0.36f, 0.31f, 0.20f};  ///< linear
    double clarity_m = 3.0;               ///< depth in which a tenth of the bed's light is left
    double wave_height_m = 0.1;           ///< in a breeze
};

/// Level of the highest water that is there or not far from there, by its outline; far below the ground where none is.
[[nodiscard]] double water_level_near(std::span<const WaterDescription> waters, double x, double z);

/// Lowers the ground to a bed that slopes from the outline to its depth, and lets what is around rise from the shore.
void dig_bed(const WaterDescription& water, HeightField& field);

/// Its material: what vertices are coloured by is a share of the bed's colour.
[[nodiscard]] scene::Material water_material(const WaterDescription& water);

/// Adds the sheet in all squares of the terrain that reach below it, by depth from the bed's colour to its own.
/// @param material  id of water_material()
void add_water_sheet(const WaterDescription& water, const HeightField& field, std::uint32_t material,
                     WorldSource& world);

}  // namespace ff::cook
