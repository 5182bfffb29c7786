// The keys of scene.toml: each is read here, once, with its range and its default (docs/scene-format.md).

#include "tools/cook/scene_toml_description.h"

#include <fmt/core.h>

#include <cmath>
#include <set>

#include "engine/scene/world.h"
#include "tools/cook/scene_toml_table.h"

namespace ff::cook {
namespace {

constexpr double kFar = 1e6;  // m: nothing by hand is placed beyond

std::array<double, 2> pair_or(const std::vector<double>& values, std::array<double, 2> fallback) {
    return values.size() == 2 ? std::array<double, 2>{values[0], values[1]} : fallback;
}
std::optional<std::array<double, 2>> pair_of(const std::vector<double>& values) {
    if (values.size() != 2) return std::nullopt;
    return std::array<double, 2>{values[0], values[1]};
}

void read_sun_and_sky(TomlTable& root, TomlReport& report, SceneDescription& scene) {
    double azimuth = 145.0, elevation = 38.0, strength = 1.0;
    if (const toml::table* table = root.table("sun")) {
        TomlTable sun(*table, "[sun]", report);
        azimuth = sun.number("azimuth_deg", azimuth, -360, 360);
        elevation = sun.number("elevation_deg", elevation, -90, 90);
        strength = sun.number("strength", strength, 0, 100);
        scene.environment.sun_shadows = sun.boolean("shadows", false);
        sun.finish();
        // Azimuth is clockwise from north (-z) towards east (+x).
        const double a = radians_of(azimuth), e = radians_of(elevation);
        scene.environment.to_sun = Vec3(std::cos(e) * std::sin(a), std::sin(e), -std::cos(e) * std::cos(a));
        scene.environment.sun_radiance = scene.environment.sun_radiance * float(strength);
        scene.environment.atmosphere.brightness = float(strength);
    }
    if (const toml::table* table = root.table("sky")) {
        TomlTable sky(*table, "[sky]", report);
        const auto color = [&](const char* key, Vec3& out) {
            const std::vector<double> rgb = sky.numbers(key, 3, 3, 0, 1000);
            if (!rgb.empty()) out = Vec3(rgb[0], rgb[1], rgb[2]);
        };
        color("zenith", scene.environment.sky_zenith);
        color("horizon", scene.environment.sky_horizon);
        scene.environment.fog_density_per_m = float(sky.number("fog_density_per_m", 0, 0, 1));
        scene.sky_panorama = sky.file("panorama");
        if (sky.choice("model", 0, {"gradient", "atmosphere"}) == 1) {
            for (const char* painted : {"zenith", "horizon", "panorama"})
                if (sky.has(painted))
                    sky.fail(painted, "stands beside model = \"atmosphere\"; expected one of the two");
            scene.environment.atmosphere.turbidity = float(sky.number("turbidity", 2, 1, 10));
        } else if (sky.has("turbidity")) {
            sky.fail("turbidity", "stands without model = \"atmosphere\"; expected it beside that alone");
        }
        sky.finish();
    }
}

void read_terrain(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[terrain]", report);
    TerrainDescription terrain;
    terrain.heightmap = table.file("heightmap");
    terrain.file.size_m = pair_of(table.numbers("size_m", 2, 2, 1, 2 * kFar));
    terrain.file.center_m = pair_of(table.numbers("center_m", 2, 2, -kFar, kFar));
    terrain.file.height_m = pair_of(table.numbers("height_m", 2, 2, -12000, 12000));
    terrain.file.vertical_scale = table.number("vertical_scale", 1, 0, 1000);
    terrain.file.spacing_m = table.optional_number("spacing_m", 0.01, 10000);
    terrain.max_error_m = table.optional_number("max_error_m", 0, 1000);
    terrain.texture = table.file("texture");
    terrain.texture_size_m = table.number("texture_size_m", 12, 0.01, 1e5);
    terrain.steep_texture = table.file("steep_texture");
    terrain.steep_deg = table.number("steep_deg", 35, 0, 90);
    terrain.natural_colors = table.boolean("natural_colors", false);
    terrain.snow_line_m = table.number("snow_line_m", 900, -12000, 12000);
    terrain.water_m = table.optional_number("water_m", -12000, 12000);
    if (table.has("generator")) {
        table.choice("generator", 0, {"valley"});
        ValleySettings valley;
        valley.seed = std::uint64_t(table.integer("seed", 1, 0, 1'000'000'000));
        valley.relief_m = table.number("relief_m", valley.relief_m, 0, 9000);
        valley.floor_width_m = table.number("floor_width_m", valley.floor_width_m, 100, kFar);
        if (terrain.file.size_m) valley.size_m = *terrain.file.size_m;
        valley.spacing_m = terrain.file.spacing_m.value_or(valley.spacing_m);
        valley.water_m = terrain.water_m.value_or(valley.water_m);
        if (std::max(valley.size_m[0], valley.size_m[1]) / valley.spacing_m > 8192)
            table.fail("spacing_m", "more than 8192 samples a side; expected a larger spacing_m");
        if (!terrain.heightmap.empty()) table.fail("generator", "stands beside heightmap; expected one of the two");
        terrain.valley = valley;
    } else if (terrain.heightmap.empty()) {
        table.fail("heightmap", "missing; expected the path of a height file, or generator = \"valley\"");
    }
    table.finish();
    scene.terrain = terrain;
}

void read_buildings(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[[buildings]]", report);
    BuildingsDescription buildings;
    buildings.footprints = table.file("footprints", true);
    buildings.properties.height = table.text("height", "height");
    buildings.properties.levels = table.text("levels", "building:levels");
    buildings.properties.base = table.text("base", "min_height");
    buildings.properties.level_height_m = table.number("level_height_m", 3.2, 1, 100);
    buildings.properties.default_height_m = table.number("default_height_m", 9, 0.1, 1000);
    buildings.roof = RoofShape(table.choice("roof", 0, {"flat", "gabled", "hipped"}));
    buildings.facade = table.file("facade");
    const std::array<double, 2> size = pair_or(table.numbers("facade_size_m", 2, 2, 0.01, 1000), {12.0, 9.6});
    buildings.facade_size_m = {size[0], size[1]};
    buildings.detail = table.boolean("detail", false);
    table.finish();
    scene.buildings.push_back(std::move(buildings));
}

void read_town(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[town]", report);
    TownDescription town;
    city::CitySettings& s = town.settings;
    s.seed = std::uint32_t(table.integer("seed", s.seed, 0, 1'000'000'000));
    const std::array<double, 2> center = pair_or(table.numbers("center_m", 2, 2, -kFar, kFar), {0.0, 0.0});
    s.center_x = center[0], s.center_z = center[1];
    s.size_m = table.number("size_m", s.size_m, 300, 20000);
    s.block_m = table.number("block_m", s.block_m, 60, 120);
    s.street_m = table.number("street_m", s.street_m, 12, 20);
    s.downtown_m = table.number("downtown_m", std::min(s.downtown_m, s.size_m), 0, s.size_m);
    s.max_height_m = table.number("max_height_m", s.max_height_m, 20, 300);
    s.detail = table.number("detail", s.detail, 0.25, 4);
    for (const auto& [key, path] :
         {std::pair{"asphalt", &town.asphalt}, std::pair{"pavement", &town.pavement}, std::pair{"grass", &town.grass},
          std::pair{"gravel", &town.gravel}, std::pair{"roof_red", &town.roof_red},
          std::pair{"roof_dark", &town.roof_dark}, std::pair{"lamp", &town.lamp}, std::pair{"bench", &town.bench}})
        *path = table.file(key);
    town.street_trees = table.files("street_trees");
    town.park_trees = table.files("park_trees");
    town.garden_trees = table.files("garden_trees");
    town.bushes = table.files("bushes");
    table.finish();
    scene.town = std::move(town);
}

void read_model(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[[model]]", report);
    ModelDescription model;
    model.file = table.file("file", true);
    const std::vector<double> position = table.numbers("position_m", 2, 3, -1e8, 1e8);
    if (!position.empty()) model.position_m = position;
    model.yaw_deg = table.number("yaw_deg", 0, -1e6, 1e6);
    model.scale = table.number("scale", 1, 1e-6, 1e6);
    model.dynamic = table.boolean("dynamic", false);
    model.sways = table.boolean("sways", false);
    model.name = table.text("name", "");
    model.animation = table.text("animation", "");
    model.animation_phase = table.number("animation_phase", 0, 0, 0.999999);
    for (const char* key : {"animation", "animation_phase"})
        if (table.has(key) && !model.dynamic) table.fail(key, "expected with dynamic = true only");
    model.flock = int(table.integer("flock", 0, 1, scene::kMostBirds));
    model.flock_radius_m = table.number("flock_radius_m", 45, 5, 1000);
    model.flock_height_m = table.number("flock_height_m", 25, 0, 10000);
    for (const char* key : {"flock_radius_m", "flock_height_m"})
        if (table.has(key) && model.flock == 0) table.fail(key, "expected with flock only");
    model.mass_kg = table.number("mass_kg", 0, 1e-3, 1e6);
    for (const char* key : {"flock", "mass_kg"})
        if (table.has(key) && !model.dynamic) table.fail(key, "expected with dynamic = true only");
    if (table.has("flock") && table.has("mass_kg"))
        table.fail("mass_kg", "stands beside flock; expected one of the two");
    table.finish();
    scene.models.push_back(std::move(model));
}

/// Names of models and places are one set.
void check_names_of_places(TomlTable& root, const SceneDescription& scene) {
    std::set<std::string> names;
    const auto check = [&](const char* key, const std::string& name) {
        if (!name.empty() && !names.insert(name).second) root.fail(key, fmt::format("\"{}\" is there twice", name));
    };
    for (const ModelDescription& model : scene.models) check("model", model.name);
    for (const PlaceDescription& place : scene.places) check("place", place.name);
}

void read_place(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[[place]]", report);
    PlaceDescription place;
    place.name = table.text("name", "");
    if (place.name.empty()) table.fail("name", "missing; expected a text in quotes");
    place.position_m = table.numbers("position_m", 2, 3, -1e8, 1e8);
    if (place.position_m.empty()) table.fail("position_m", "missing; expected [x, z] or [x, y, z]");
    place.yaw_deg = table.number("yaw_deg", 0, -1e6, 1e6);
    table.finish();
    scene.places.push_back(std::move(place));
}

void read_scatter(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[[scatter]]", report);
    ScatterDescription scatter;
    const bool single = table.has("file"), several = table.has("files");
    if (single == several) table.fail("file", "expected either file or files");
    if (single) scatter.files = {table.file("file")};
    if (several) scatter.files = table.files("files");
    scatter.weights = table.numbers("weights", scatter.files.size(), scatter.files.size(), 0, 1e9);
    if (scatter.weights.empty()) scatter.weights.assign(scatter.files.size(), 1.0);
    double total = 0;
    for (const double w : scatter.weights) total += w;
    if (!(total > 0)) table.fail("weights", "all zero; expected one above zero");
    if (!table.has("density_per_km2")) table.fail("density_per_km2", "missing; expected a number");
    scatter.density_per_km2 = table.number("density_per_km2", 0, 0, 1e7);
    scatter.area_m = table.numbers("area_m", 4, 4, -kFar, kFar);
    scatter.polygons = table.file("polygons");
    if (scatter.area_m.empty() == scatter.polygons.empty())
        table.fail("area_m", "expected either area_m = [x0, z0, x1, z1] or polygons");
    if (scatter.area_m.size() == 4 && !(scatter.area_m[0] < scatter.area_m[2] && scatter.area_m[1] < scatter.area_m[3]))
        table.fail("area_m", "covers nothing; expected [x0, z0, x1, z1] with x0 < x1 and z0 < z1");
    if (scatter.area_m.size() == 4 && (scatter.area_m[2] - scatter.area_m[0]) *
                                              (scatter.area_m[3] - scatter.area_m[1]) * 1e-6 * scatter.density_per_km2 >
                                          4e6)
        table.fail("density_per_km2", "more than 4 million instances; expected a smaller area or density");
    scatter.slope_max_deg = table.number("slope_max_deg", 90, 0, 90);
    scatter.clump_m = table.number("clump_m", 0, 0, 1e5);
    scatter.height_m = pair_of(table.numbers("height_m", 2, 2, -12000, 12000));
    scatter.scale = pair_or(table.numbers("scale", 2, 2, 1e-3, 1e3), {1.0, 1.0});
    scatter.sways = table.boolean("sways", true);
    scatter.seed = std::uint64_t(table.integer("seed", 1, 0, 1'000'000'000));
    table.finish();
    scene.scatters.push_back(std::move(scatter));
}

void read_sound_table(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[[sound]]", report);
    SoundDescription sound;
    sound.file = table.file("file", true);
    sound.name = table.text("name", "");
    if (sound.name.empty()) sound.name = sound.file.stem().string();
    const auto is_same = [&](const SoundDescription& other) { return other.name == sound.name; };
    if (std::any_of(scene.sounds.begin(), scene.sounds.end(), is_same))
        table.fail(table.has("name") ? "name" : "file", fmt::format("\"{}\" is there twice", sound.name));
    sound.positions_m = table.points("positions_m", 2, 3);
    sound.reference_m = float(table.number("reference_m", sound.reference_m, 0.1, 1e4));
    sound.gain = float(table.number("gain", sound.gain, 0, 1));
    table.finish();
    scene.sounds.push_back(std::move(sound));
}

void read_lamp(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[[lamp]]", report);
    LampDescription lamp;
    lamp.model = table.file("model");
    lamp.position_m = table.numbers("position_m", 2, 3, -kFar, kFar);
    if (lamp.model.empty() == lamp.position_m.empty())
        table.fail("position_m", "expected either it or model, a model whose every placement has such a lamp");
    const std::vector<double> offset = table.numbers("offset_m", 3, 3, -1000, 1000);
    if (!offset.empty()) lamp.offset_m = {offset[0], offset[1], offset[2]};
    const std::vector<double> color = table.numbers("color", 3, 3, 0, 1);
    if (!color.empty()) lamp.lamp.color = Vec3(color[0], color[1], color[2]);
    lamp.lamp.lumens = float(table.number("lumens", lamp.lamp.lumens, 0, 1e6));
    lamp.lamp.radius_m = float(table.number("radius_m", lamp.lamp.radius_m, 0.1, 1000));
    lamp.lamp.on_below_sun_deg = float(table.number("on_below_sun_deg", lamp.lamp.on_below_sun_deg, -90, 90));
    table.finish();
    scene.lamps.push_back(std::move(lamp));
}

void read_water(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[[water]]", report);
    WaterDescription water;
    if (!table.has("level_m")) table.fail("level_m", "missing; expected the height of the surface, metres");
    water.level_m = table.number("level_m", 0, -12000, 12000);
    const std::vector<double> area = table.numbers("area_m", 4, 4, -kFar, kFar);
    if (!area.empty()) water.outline = {{area[0], area[1]}, {area[2], area[1]}, {area[2], area[3]}, {area[0], area[3]}};
    const std::vector<std::vector<double>> polygon = table.points("polygon_m", 2, 2);
    if (!area.empty() && !polygon.empty()) table.fail("polygon_m", "expected either it or area_m");
    if (!polygon.empty() && polygon.size() < 3) table.fail("polygon_m", "expected at least three points");
    for (const std::vector<double>& p : polygon) water.outline.emplace_back(p[0], p[1]);
    water.depth_m = table.optional_number("depth_m", 0, 1000);
    if (water.depth_m && water.outline.empty()) table.fail("depth_m", "expected area_m or polygon_m with it");
    const auto read_color = [&](const char* key, Vec3& color) {
        const std::vector<double> c = table.numbers(key, 3, 3, 0, 1);
        if (!c.empty()) color = Vec3(c[0], c[1], c[2]);
    };
    read_color("color", water.color);
    read_color("bed_color", water.bed_color);
    water.clarity_m = table.number("clarity_m", water.clarity_m, 0.01, 1000);
    water.wave_height_m = table.number("wave_height_m", water.wave_height_m, 0, 0.5);
    table.finish();
    scene.waters.push_back(std::move(water));
}

void read_weather(const toml::table& source, TomlReport& report, SceneDescription& scene) {
    TomlTable table(source, "[weather]", report);
    scene::Weather& weather = scene.environment.weather;
    weather.rain = float(table.number("rain", 0, 0, 1));
    weather.snow = float(table.number("snow", 0, 0, 1));
    const double speed = table.number("wind_m_s", 0, 0, 60),
                 from = radians_of(table.number("wind_from_deg", 270, -360, 360));
    weather.wind_m_s = Vec2(-speed * std::sin(from), speed * std::cos(from));
    table.finish();
}

void read_spawn_and_walks(TomlTable& root, TomlReport& report, SceneDescription& scene) {
    if (const toml::table* source = root.table("spawn")) {
        TomlTable table(*source, "[spawn]", report);
        const std::vector<double> p = table.numbers("position_m", 2, 3, -1e8, 1e8);
        const double yaw = table.number("yaw_deg", 0, -1e6, 1e6);
        if (p.empty()) table.fail("position_m", "missing; expected [x, z] or [x, y, z]");
        if (!p.empty()) scene.spawn = {p.front(), p.back(), yaw};
        if (p.size() == 3) scene.spawn_y = p[1];
        table.finish();
    }
    std::set<std::string> names;
    for (const toml::table* source : root.tables("walk")) {
        TomlTable table(*source, "[[walk]]", report);
        WalkDescription walk;
        walk.name = table.text("name", "");
        if (walk.name.empty()) table.fail("name", "missing; expected a text in quotes");
        if (!names.insert(walk.name).second) table.fail("name", fmt::format("\"{}\" is there twice", walk.name));
        walk.file = table.file("file");
        walk.points_m = table.points("points_m", 2, 3);
        walk.speed_m_s = table.number("speed_m_s", 1.6, 0.01, 10000);
        walk.eye_height_m = table.number("eye_height_m", 1.7, -1000, 10000);
        if (walk.file.empty() == walk.points_m.empty()) table.fail("file", "expected either file or points_m");
        if (!walk.points_m.empty() && walk.points_m.size() < 2) table.fail("points_m", "expected at least two points");
        table.finish();
        scene.walks.push_back(std::move(walk));
    }
}

}  // namespace

Result<SceneDescription> read_scene_description(const std::filesystem::path& path) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored))
        return bad_input(fmt::format("{}: no such file", path.string()));
    toml::table parsed;
    try {
        parsed = toml::parse_file(path.string());
    } catch (const toml::parse_error& error) {
        return bad_input(fmt::format("{}:{}: not TOML: {}", path.string(), error.source().begin.line,
                                     std::string(error.description())));
    }
    TomlReport report{path, {}};
    TomlTable root(parsed, "scene.toml", report);
    SceneDescription scene;
    if (!root.has("format")) root.fail("format", "missing; expected format = 1");
    root.integer("format", 1, 1, 1);
    scene.name = root.text("name", path.stem().string());
    if (const toml::table* source = root.table("georeference")) {
        TomlTable table(*source, "[georeference]", report);
        for (const char* key : {"latitude_deg", "longitude_deg"})
            if (!table.has(key)) table.fail(key, "missing; expected degrees");
        scene.frame =
            GroundFrame{table.number("latitude_deg", 0, -90, 90), table.number("longitude_deg", 0, -180, 180)};
        table.finish();
    }
    read_sun_and_sky(root, report, scene);
    if (const toml::table* source = root.table("terrain")) read_terrain(*source, report, scene);
    for (const toml::table* source : root.tables("buildings")) read_buildings(*source, report, scene);
    if (const toml::table* source = root.table("town")) read_town(*source, report, scene);
    for (const toml::table* source : root.tables("model")) read_model(*source, report, scene);
    for (const toml::table* source : root.tables("place")) read_place(*source, report, scene);
    check_names_of_places(root, scene);
    for (const toml::table* source : root.tables("scatter")) read_scatter(*source, report, scene);
    for (const toml::table* source : root.tables("sound")) read_sound_table(*source, report, scene);
    for (const toml::table* source : root.tables("lamp")) read_lamp(*source, report, scene);
    for (const toml::table* source : root.tables("water")) read_water(*source, report, scene);
    if (!scene.waters.empty() && !scene.terrain) root.fail("water", "expected a [terrain] for it to lie in");
    if (const toml::table* source = root.table("weather")) read_weather(*source, report, scene);
    read_spawn_and_walks(root, report, scene);
    root.finish();
    if (report.error) return *report.error;
    return scene;
}

}  // namespace ff::cook
