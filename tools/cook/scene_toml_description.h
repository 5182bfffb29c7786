#pragma once
// A scene.toml as plain data: what is written, with defaults filled in and ranges checked, and nothing else read yet.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/scene/environment.h"
#include "engine/scene/lamp.h"
#include "tools/cook/buildings.h"
#include "tools/cook/city.h"
#include "tools/cook/ground_frame.h"
#include "tools/cook/terrain.h"
#include "tools/cook/terrain_valley.h"
#include "tools/cook/water.h"

namespace ff::cook {

struct TerrainDescription {
    std::filesystem::path heightmap;  ///< empty: `valley`
    std::optional<ValleySettings> valley;
    HeightFileSettings file;
    std::optional<double> max_error_m;
    std::filesystem::path texture, steep_texture;
    double texture_size_m = 12.0, steep_deg = 35.0;
    bool natural_colors = false;
    double snow_line_m = 900.0;
    std::optional<double> water_m;
};

struct BuildingsDescription {
    std::filesystem::path footprints, facade;
    FootprintSettings properties;
    RoofShape roof = RoofShape::flat;
    DVec2 facade_size_m{12.0, 9.6};
    bool detail = false;
};

struct TownDescription {
    city::CitySettings settings;                                                  ///< scale is the cook's
    std::filesystem::path asphalt, pavement, grass, gravel, roof_red, roof_dark;  ///< textures
    std::filesystem::path lamp, bench;
    std::vector<std::filesystem::path> street_trees, park_trees, garden_trees, bushes;
};

struct ModelDescription {
    std::filesystem::path file;
    std::vector<double> position_m{0.0, 0.0};  ///< [x, z] or [x, y, z]
    double yaw_deg = 0, scale = 1;
    bool dynamic = false;
    bool sways = false;          ///< wind moves its masked materials
    std::string name;            ///< empty: none
    std::string animation;       ///< clip that it plays; empty: the first
    double animation_phase = 0;  ///< [0, 1)
    int flock = 0;               ///< so many of it fly together; 0: it stands
    double flock_radius_m = 45, flock_height_m = 25;
    double mass_kg = 0;  ///< of a rigid body; 0: it is none
};

struct PlaceDescription {
    std::string name;
    std::vector<double> position_m;  ///< [x, z] or [x, y, z]
    double yaw_deg = 0;
};

struct ScatterDescription {
    std::vector<std::filesystem::path> files;
    std::vector<double> weights;
    double density_per_km2 = 0;
    std::vector<double> area_m;
    std::filesystem::path polygons;
    double slope_max_deg = 90, clump_m = 0;
    std::array<double, 2> scale{1, 1};
    std::optional<std::array<double, 2>> height_m;
    std::uint64_t seed = 1;
    bool sways = true;  ///< wind moves their masked materials
};

struct LampDescription {
    std::filesystem::path model;     ///< every placement of it has one; empty: position_m says where
    std::vector<double> position_m;  ///< [x, z]: offset_m above the ground; or [x, y, z]
    std::array<double, 3> offset_m{0, 0, 0};
    scene::Lamp lamp;
};

struct SoundDescription {
    std::filesystem::path file;
    std::string name;  ///< empty: the file's, without its ending
    /// [x, z] on the ground or [x, y, z], a source at each; none: for games to play
    std::vector<std::vector<double>> positions_m;
    float reference_m = 5.0f, gain = 1.0f;
};

struct WalkDescription {
    std::string name;
    std::filesystem::path file;
    std::vector<std::vector<double>> points_m;
    double speed_m_s = 1.6, eye_height_m = 1.7;
};

struct SceneDescription {
    std::string name;
    std::optional<GroundFrame> frame;
    scene::Environment environment;
    std::filesystem::path sky_panorama;
    std::optional<TerrainDescription> terrain;
    std::vector<BuildingsDescription> buildings;
    std::optional<TownDescription> town;
    std::vector<ModelDescription> models;
    std::vector<ScatterDescription> scatters;
    std::vector<LampDescription> lamps;
    std::vector<SoundDescription> sounds;
    std::vector<WaterDescription> waters;
    std::optional<std::array<double, 3>> spawn;  ///< x, z, yaw
    std::optional<double> spawn_y;
    std::vector<WalkDescription> walks;
    std::vector<PlaceDescription> places;
};

/// Reads and checks the text of a scene.toml. Errors: see load_scene_toml.
[[nodiscard]] Result<SceneDescription> read_scene_description(const std::filesystem::path& path);

}  // namespace ff::cook
