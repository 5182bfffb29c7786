#include <gtest/gtest.h>

#include <fmt/core.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "engine/core/jobs.h"
#include "tests/support/temporary_folder.h"
#include "tools/cook/scene_toml.h"
#include "tools/cook/scene_toml_description.h"

namespace ff::cook {
namespace {

namespace fs = std::filesystem;

class SceneToml : public testing::Test {
  protected:
    fs::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    std::string error_of(const std::string& text) const {
        const Result<SceneDescription> scene = read_scene_description(write("scene.toml", text));
        return scene ? "" : scene.error().message;
    }
    Result<WorldSource> load(const std::string& text, int scale = 1) {
        CookCache cache;
        CookContext context(cache);
        return load_scene_toml(write("scene.toml", text), {.scale = scale}, context);
    }
    static std::size_t triangles(const WorldSource& world) {
        std::size_t count = 0;
        for (const Placement& placement : world.placements)
            count += world.meshes[placement.mesh].geometry.triangle_materials.size();
        return count;
    }

    test::TemporaryFolder folder_;
};

/// Three houses of about 11 x 10 m around 47 N 10 E, one of them with a yard, and two that are none.
constexpr const char* kHouses = R"({"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"height": 12}, "geometry": {"type": "Polygon", "coordinates":
 [[[10.0, 47.0], [10.00015, 47.0], [10.00015, 47.0001], [10.0, 47.0001], [10.0, 47.0]]]}},
{"type": "Feature", "properties": {"building:levels": "3", "name": "yard"}, "geometry": {"type": "Polygon", "coordinates":
 [[[10.0005, 47.0], [10.001, 47.0], [10.001, 47.0004], [10.0005, 47.0004], [10.0005, 47.0]],
  [[10.0006, 47.0001], [10.0006, 47.0003], [10.0009, 47.0003], [10.0009, 47.0001], [10.0006, 47.0001]]]}},
{"type": "Feature", "properties": {"height": "9 m", "min_height": 3}, "geometry": {"type": "MultiPolygon", "coordinates":
 [[[[10.0, 47.0005], [10.00015, 47.0005], [10.00015, 47.0006], [10.0, 47.0006], [10.0, 47.0005]]]]}},
{"type": "Feature", "properties": {"name": "bow tie"}, "geometry": {"type": "Polygon", "coordinates":
 [[[10.002, 47.0], [10.0021, 47.0001], [10.0021, 47.0], [10.002, 47.0001], [10.002, 47.0]]]}},
{"type": "Feature", "properties": {"name": "line"}, "geometry": {"type": "Polygon", "coordinates":
 [[[10.003, 47.0], [10.0031, 47.0], [10.003, 47.0], [10.003, 47.0]]]}}
]})";
constexpr const char* kHouseScene =
    "format = 1\n[georeference]\nlatitude_deg = 47\nlongitude_deg = 10\n[[buildings]]\nfootprints = "
    "\"houses.geojson\"\n";

TEST_F(SceneToml, an_unknown_key_is_named_with_its_line_and_the_nearest_known_one) {
    const std::string error = error_of("format = 1\n\n[sun]\nazimut_deg = 3\n");
    EXPECT_NE(error.find("scene.toml:4: [sun] azimut_deg"), std::string::npos) << error;
    EXPECT_NE(error.find("nearest known one is azimuth_deg"), std::string::npos) << error;
    EXPECT_NE(error_of("format = 1\nterain = 3\n").find(":2: scene.toml terain"), std::string::npos);
}

TEST_F(SceneToml, an_atmosphere_weather_and_lamps_are_read) {
    const Result<WorldSource> world = load(
        "format = 1\n[sun]\nstrength = 0.5\n[sky]\nmodel = \"atmosphere\"\nturbidity = 3\n"
        "[weather]\nrain = 0.5\nwind_m_s = 4\nwind_from_deg = 270\n"
        "[town]\nsize_m = 300\n[[lamp]]\nposition_m = [3.0, 5.0, -2.0]\noffset_m = [0, 1, 0]\nlumens = 900\n"
        "[[lamp]]\nposition_m = [3.0, -2.0]\noffset_m = [0, 4, 0]\n");
    ASSERT_TRUE(world) << world.error().message;
    const scene::Environment& environment = world->environment;
    EXPECT_EQ(environment.atmosphere, (scene::Atmosphere{3.0f, 0.5f}));
    EXPECT_EQ(environment.weather.rain, 0.5f);
    EXPECT_NEAR(environment.weather.wind_m_s.x, 4.0f, 1e-4f) << "from the west to the east";
    EXPECT_NEAR(environment.weather.wind_m_s.y, 0.0f, 1e-4f);
    ASSERT_EQ(world->lamps.size(), 2u);
    EXPECT_EQ(world->lamps[0].position, DVec3(3.0, 6.0, -2.0));
    EXPECT_EQ(world->lamps[0].lumens, 900.0f);
    EXPECT_NEAR(world->lamps[1].position.y, 4.0, 0.5) << "above the ground";
}

TEST_F(SceneToml, sounds_are_read_and_stand_where_they_are_heard) {
    // A WAV file of two channels, four frames: what libsndfile reads is mixed into one.
    std::string wave("RIFF\x34\0\0\0WAVEfmt \x10\0\0\0\1\0\2\0\x40\x1f\0\0\0\x7d\0\0\4\0\x10\0data\x10\0\0\0", 44);
    for (const int sample : {100, 300, -200, -400, 0, 0, 32767, 32767}) {
        wave.push_back(char(sample & 255));
        wave.push_back(char(sample >> 8));
    }
    write("brook.wav", wave);
    const std::string town = "format = 1\n[town]\nsize_m = 300\n[[sound]]\nfile = \"brook.wav\"\n";
    const Result<WorldSource> world = load(town +
                                           "positions_m = [[3.0, 9.0, -2.0], [1.0, 1.0]]\nreference_m = 8\n"
                                           "[[sound]]\nfile = \"brook.wav\"\nname = \"splash\"\n");
    ASSERT_TRUE(world) << world.error().message;
    ASSERT_EQ(world->sounds.clips.size(), 2u);
    EXPECT_EQ(world->sounds.clips[0].name, "brook");
    EXPECT_EQ(world->sounds.clips[0].rate_hz, 8000u);
    ASSERT_EQ(world->sounds.clips[0].samples.size(), 4u);
    EXPECT_NEAR(world->sounds.clips[0].samples[0], 200, 1);
    EXPECT_NEAR(world->sounds.clips[0].samples[1], -300, 1);
    EXPECT_NEAR(world->sounds.clips[0].samples[3], 32767, 2);
    EXPECT_EQ(find_sound(world->sounds, "splash"), 1u);
    EXPECT_EQ(find_sound(world->sounds, "thunder"), scene::kNoSound);
    ASSERT_EQ(world->sounds.sources.size(), 2u) << "the second is for games";
    EXPECT_EQ(world->sounds.sources[0].position, DVec3(3.0, 9.0, -2.0));
    EXPECT_EQ(world->sounds.sources[0].reference_m, 8.0f);
    EXPECT_NEAR(world->sounds.sources[1].position.y, 0.0, 0.5) << "on the ground";

    EXPECT_NE(error_of(town + "[[sound]]\nfile = \"brook.wav\"\n").find("twice"), std::string::npos);
    EXPECT_NE(error_of(town + "gain = 2\n").find("[0, 1]"), std::string::npos);
    write("brook.wav", "no sound at all");
    const Result<WorldSource> broken = load(town);
    ASSERT_FALSE(broken);
    EXPECT_NE(broken.error().message.find("brook.wav: "), std::string::npos) << broken.error().message;
}

TEST_F(SceneToml, masked_leaves_sway_where_plants_are_scattered_and_of_models_that_say_so) {
    fs::copy_file(fs::path(FF_CONTENT_DIR) / "models" / "oak.glb", folder_ / "oak.glb");
    const auto sways = [&](const std::string& text) {
        const Result<WorldSource> world = load("format = 1\n[town]\nsize_m = 300\n" + text);
        EXPECT_TRUE(world) << world.error().message;
        int count = 0;
        for (const scene::Material& material : world->materials) {
            if ((material.flags & scene::kMaterialSways) == 0) continue;
            EXPECT_NE(material.flags & scene::kMaterialAlphaMask, 0u) << "bark stands still";
            ++count;
        }
        return count;
    };
    const std::string scatter =
        "[[scatter]]\nfile = \"oak.glb\"\ndensity_per_km2 = 100\narea_m = [-400, -400, 400, 400]\n";
    EXPECT_EQ(sways(scatter), 1);
    EXPECT_EQ(sways(scatter + "sways = false\n"), 0);
    EXPECT_EQ(sways("[[model]]\nfile = \"oak.glb\"\n"), 0);
    EXPECT_EQ(sways("[[model]]\nfile = \"oak.glb\"\nsways = true\n"), 1);
    EXPECT_EQ(sways("[[model]]\nfile = \"oak.glb\"\ndynamic = true\nsways = true\n"), 1);
    EXPECT_EQ(sways("street_trees = [\"oak.glb\"]\n"), 1);
}

TEST_F(SceneToml, flocks_fly_over_their_place_and_bodies_have_a_mass) {
    for (const char* file : {"bird.glb", "barrel.glb"})
        fs::copy_file(fs::path(FF_CONTENT_DIR) / "models" / file, folder_ / file);
    const std::string bird = "format = 1\n[[model]]\nfile = \"bird.glb\"\n";
    const std::string barrel = "format = 1\n[[model]]\nfile = \"barrel.glb\"\n";
    const Result<WorldSource> world =
        load(bird + "dynamic = true\nposition_m = [3, 5, 7]\nflock = 9\nflock_height_m = 20\n" +
             "[[model]]\nfile = \"barrel.glb\"\ndynamic = true\nmass_kg = 12\nname = \"tun\"\n");
    ASSERT_TRUE(world) << world.error().message;
    ASSERT_EQ(world->places.size(), 2u);
    EXPECT_EQ(world->places[0].flock, 9u);
    EXPECT_EQ(world->places[0].flock_radius_m, 45.0f);
    EXPECT_EQ(world->places[0].position, DVec3(3, 25, 7));
    EXPECT_EQ(world->places[0].animated_count, 1u);
    EXPECT_EQ(world->places[1].mass_kg, 12.0f);
    EXPECT_EQ(world->places[1].placement_count, 1u);
    const auto expect = [&](const std::string& text, const std::string& what) {
        EXPECT_NE(error_of(text).find(what), std::string::npos) << error_of(text);
    };
    expect(bird + "flock = 9\n", "flock");
    expect(bird + "dynamic = true\nflock = 257\n", "256");
    expect(bird + "dynamic = true\nflock_radius_m = 20\n", "expected with flock only");
    expect(bird + "dynamic = true\nflock = 2\nmass_kg = 2\n", "expected one of the two");
    const Result<WorldSource> animated = load(bird + "dynamic = true\nmass_kg = 2\n");
    ASSERT_FALSE(animated);
    EXPECT_NE(animated.error().message.find("bird.glb: is animated"), std::string::npos) << animated.error().message;
    expect(barrel + "mass_kg = 2\n", "expected with dynamic = true only");
    expect(barrel + "dynamic = true\nmass_kg = -2\n", "mass_kg");
}

TEST_F(SceneToml, two_skies_and_placeless_lamps_are_refused) {
    EXPECT_NE(error_of("format = 1\n[sky]\nmodel = \"atmosphere\"\nzenith = [0, 0, 1]\n").find("zenith"),
              std::string::npos);
    EXPECT_NE(error_of("format = 1\n[sky]\nturbidity = 3\n").find("turbidity"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[sky]\nmodel = \"cubes\"\n").find("atmosphere"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[[lamp]]\nlumens = 3\n").find("position_m"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[weather]\nsnow = 2\n").find("[0, 1]"), std::string::npos);
}

TEST_F(SceneToml, wrong_types_and_ranges_are_told_with_what_was_expected) {
    EXPECT_NE(error_of("format = 1\n[sun]\nelevation_deg = \"high\"\n").find(":3: [sun] elevation_deg"),
              std::string::npos);
    EXPECT_NE(error_of("format = 1\n[sun]\nelevation_deg = 91\n").find("[-90, 90]"), std::string::npos);
    EXPECT_NE(error_of("format = 2\n").find("format = 2"), std::string::npos);
    EXPECT_NE(error_of("name = \"x\"\n").find("format: missing"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[sun\n").find(":2: not TOML"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[terrain]\nheightmap = \"none.tif\"\n").find("there is none at"),
              std::string::npos);
    EXPECT_NE(error_of("format = 1\n[terrain]\nspacing_m = 3\n").find("heightmap: missing"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[[walk]]\nname = \"a\"\n").find("either file or points_m"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[[model]]\nposition_m = [1]\n").find("[[model]] file: missing"), std::string::npos);
    EXPECT_NE(error_of("format = 1\n[sky]\nzenith = [1, nan, 2]\n").find("3 numbers"), std::string::npos);
}

TEST_F(SceneToml, a_file_that_is_not_there_is_an_error) {
    EXPECT_FALSE(read_scene_description(folder_ / "none.toml"));
}

TEST_F(SceneToml, a_scene_of_nothing_is_an_error) {
    const Result<WorldSource> world = load("format = 1\n");
    ASSERT_FALSE(world);
    EXPECT_NE(world.error().message.find("nothing to draw"), std::string::npos) << world.error().message;
}

TEST_F(SceneToml, houses_stand_where_their_degrees_say) {
    write("houses.geojson", kHouses);
    const Result<WorldSource> world = load(kHouseScene);
    ASSERT_TRUE(world) << world.error().message;
    DBox3 bounds;
    for (const Placement& placement : world->placements)
        for (const Vec3& p : world->meshes[placement.mesh].geometry.positions)
            bounds.add(placement.position + DVec3(placement.world_from_mesh * p));
    EXPECT_NEAR(bounds.low.x, 0.0, 0.01);
    EXPECT_NEAR(bounds.high.x, 0.001 * 76055.0, 1.0);  // a degree of longitude at 47 N
    EXPECT_NEAR(bounds.high.z, 0.0, 0.01);
    EXPECT_NEAR(bounds.low.z, -0.0006 * 111170.0, 0.5);
    EXPECT_NEAR(bounds.high.y, 12.0, 1e-3);
    EXPECT_EQ(world->walks.size(), 5u);
}

TEST_F(SceneToml, walls_face_outwards_and_roofs_upwards) {
    write("houses.geojson", kHouses);
    const Result<WorldSource> world = load(kHouseScene);
    ASSERT_TRUE(world) << world.error().message;
    double volume = 0;  // of a closed surface; the plinth's missing floor lies 0.4 m below the ground
    for (const Placement& placement : world->placements) {
        const scene::MeshSource& mesh = world->meshes[placement.mesh].geometry;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            const auto corner = [&](std::size_t k) {
                return placement.position + DVec3(mesh.positions[mesh.indices[i + k]]) + DVec3(0, 0.4, 0);
            };
            volume += glm::dot(corner(0), glm::cross(corner(1), corner(2))) / 6.0;
        }
    }
    const double house = 0.00015 * 76055 * 0.0001 * 111170;
    const double yard = 76055.0 * 111170.0 * (0.0005 * 0.0004 - 0.0003 * 0.0002);
    EXPECT_NEAR(volume, house * 12.4 + yard * (9.6 + 0.4) + house * 6.0, 0.02 * volume);
}

TEST_F(SceneToml, detail_adds_windows_and_the_scale_adds_copies) {
    write("houses.geojson", kHouses);
    const Result<WorldSource> plain = load(kHouseScene);
    const Result<WorldSource> rich = load(std::string(kHouseScene) + "detail = true\nroof = \"gabled\"\n");
    const Result<WorldSource> many = load(kHouseScene, 4);
    ASSERT_TRUE(plain && rich && many);
    EXPECT_GT(triangles(*rich), 20 * triangles(*plain));
    EXPECT_EQ(triangles(*many), 4 * triangles(*plain));
}

TEST_F(SceneToml, outlines_that_are_no_buildings_are_counted_and_named) {
    write("houses.geojson", kHouses);
    CookCache cache;
    CookContext context(cache);
    ASSERT_TRUE(load_scene_toml(write("scene.toml", kHouseScene), {}, context));
    ASSERT_EQ(context.warnings().size(), 1u);
    EXPECT_NE(context.warnings()[0].find("2 outlines left out"), std::string::npos) << context.warnings()[0];
    EXPECT_NE(context.warnings()[0].find("bow tie"), std::string::npos) << context.warnings()[0];
}

TEST_F(SceneToml, a_footprint_file_that_is_none_is_an_error) {
    write("houses.geojson", "{\"type\": \"FeatureColl");
    EXPECT_FALSE(load(kHouseScene));
    write("houses.geojson", "{\"type\": \"FeatureCollection\", \"features\": []}");
    EXPECT_FALSE(load(kHouseScene));
}

TEST_F(SceneToml, a_walk_by_points_keeps_its_speed_and_looks_ahead) {
    write("houses.geojson", kHouses);
    const Result<WorldSource> world =
        load(std::string(kHouseScene) +
             "[[walk]]\nname = \"round\"\npoints_m = [[200, 50], [230, 50], [230, 20]]\nspeed_m_s = 3\n");
    ASSERT_TRUE(world) << world.error().message;
    const SourceWalk& walk = world->walks[0];
    ASSERT_EQ(walk.name, "round");
    ASSERT_NEAR(double(walk.frames.size()), 601.0, 1.0);
    EXPECT_NEAR(walk.frames[0].yaw_deg, 90.0, 1e-6);
    EXPECT_NEAR(walk.frames.back().yaw_deg, 0.0, 1e-6);
    EXPECT_NEAR(walk.frames[0].position.y, 1.7, 1e-6);
    for (std::size_t i = 1; i < 290; ++i)
        EXPECT_NEAR(walk.frames[i].position.x - walk.frames[i - 1].position.x, 0.1, 1e-5);
}

TEST_F(SceneToml, the_sample_world_is_the_same_for_any_number_of_workers) {
    // A small relative of content/valley.toml: everything that is made by rule, little of it.
    const std::string text =
        "format = 1\n[terrain]\ngenerator = \"valley\"\nsize_m = [4000, 4000]\nspacing_m = 40\nfloor_width_m = 2500\n"
        "water_m = -4\nnatural_colors = true\n[town]\nsize_m = 300\ndowntown_m = 100\n";
    const auto digest = [&](int workers) {
        const WorkerLimit limit(workers);
        const Result<WorldSource> world = load(text);
        EXPECT_TRUE(world) << (world ? "" : world.error().message);
        std::uint64_t hash = 0;
        if (!world) return hash;
        for (const SourceMesh& mesh : world->meshes) {
            hash = hash * 31 + mesh.geometry.indices.size();
            for (const Vec3& p : mesh.geometry.positions)
                for (int c = 0; c < 3; ++c) hash = hash * 31 + std::bit_cast<std::uint32_t>(p[c]);
        }
        return hash;
    };
    const std::uint64_t one = digest(1);
    EXPECT_NE(one, 0u);
    EXPECT_EQ(one, digest(2));
}

}  // namespace
}  // namespace ff::cook
