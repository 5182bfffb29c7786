#pragma once
// Buildings from footprints: walls, roofs, and by rule the windows, ledges and doors.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "tools/cook/buildings_footprint.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/ground_frame.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

enum class RoofShape { flat, gabled, hipped };

struct FootprintSettings {
    std::string height = "height", levels = "building:levels", base = "min_height";  ///< properties' names
    double level_height_m = 3.2;
    double default_height_m = 9.0;
};

/// What the outlines of a file stand for.
enum class OutlineKind {
    buildings,
    woods,  ///< areas that something grows on; heights mean nothing
};

/// Reads all Polygon and MultiPolygon features of a file through OGR; of OpenStreetMap extracts those tagged as
/// buildings, or as wood, forest, scrub or orchard. A frame that is not there yet becomes the middle of the features.
/// Self-intersecting and absurd outlines are left out with one counted warning that names the first. Errors: bad_input
/// for a file that OGR cannot read or that holds no polygons.
[[nodiscard]] Result<std::vector<Footprint>> read_footprints(const std::filesystem::path& path,
                                                             const FootprintSettings& settings, OutlineKind kind,
                                                             std::optional<GroundFrame>& frame, CookContext& context);

struct BuildingLook {
    RoofShape roof = RoofShape::flat;  ///< gabled and hipped where the footprint is four-sided
    bool detail = false;
    DVec2 facade_size_m{12.0, 9.6};  ///< what one tile of the wall's texture covers
    double level_height_m = 3.2;
    std::uint32_t wall_material = 0, roof_material = 0, flat_roof_material = 0, glass_material = 0, trim_material = 0,
                  door_material = 0;
    bool tint = true;  ///< vary the wall's colour from house to house
};

/// Appends one mesh for every square of 256 m. A building stands on the lowest ground under its outline.
/// @param ground  height at (x, z)
void add_buildings(const std::vector<Footprint>& footprints, const BuildingLook& look,
                   const std::function<double(double, double)>& ground, WorldSource& world);

}  // namespace ff::cook
