// Sources of scenes that other tests leave out: skies, 16-bit heightmaps, woods and OpenStreetMap extracts.

#include <OpenImageIO/imageio.h>
#include <fmt/core.h>

#include <cmath>

#include "tests/cook/gltf_builder.h"
#include "tools/cook/scene_toml.h"
#include "tools/cook/terrain.h"

namespace ff::test {
namespace {

namespace fs = std::filesystem;
using cook::Placement;
using cook::PlacementKind;
using cook::WorldSource;

float float_of_half(std::uint16_t half) {
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    return exponent == 0 ? std::ldexp(float(mantissa), -24) : std::ldexp(float(mantissa + 1024), exponent - 25);
}

class SceneSources : public testing::Test {
  protected:
    template <class T>
    void write_image(const std::string& name, int width, int height, int channels, OIIO::TypeDesc::BASETYPE type,
                     const std::vector<T>& values) const {
        const auto out = OIIO::ImageOutput::create((folder_ / name).string());
        ASSERT_TRUE(out) << OIIO::geterror();
        ASSERT_TRUE(out->open((folder_ / name).string(), OIIO::ImageSpec(width, height, channels, type)));
        ASSERT_TRUE(out->write_image(type, values.data())) << out->geterror();
        ASSERT_TRUE(out->close());
    }
    Result<WorldSource> load(const std::string& text) {
        write_bytes(folder_ / "scene.toml", "format = 1\n" + text);
        cook::CookCache cache;
        cook::CookContext context(cache);
        return cook::load_scene_toml(folder_ / "scene.toml", {}, context);
    }
    static std::string error_of(const Result<WorldSource>& world) { return world ? "" : world.error().message; }
    static fs::path shared(const char* file) { return fs::path(FF_SHARED_DIR) / "content" / file; }
    TemporaryFolder folder_;
};

constexpr const char* kSky = "[[model]]\nfile = \"tree.glb\"\n[sky]\npanorama = ";

TEST_F(SceneSources, a_sky_panorama_arrives_in_linear_half_floats) {
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    std::vector<float> texels;
    for (int i = 0; i < 8 * 4; ++i) texels.insert(texels.end(), {0.25f * float(i), 1.0f, i == 5 ? 1e6f : 0.0f});
    for (const char* name : {"sky.exr", "sky.hdr"}) {
        SCOPED_TRACE(name);
        write_image(name, 8, 4, 3, OIIO::TypeDesc::FLOAT, texels);
        const Result<WorldSource> world = load(fmt::format("{}\"{}\"\n", kSky, name));
        ASSERT_TRUE(world) << error_of(world);
        EXPECT_EQ(world->environment.panorama_width, 8u);
        EXPECT_EQ(world->environment.panorama_height, 4u);
        ASSERT_EQ(world->sky_panorama.size(), 8u * 4u * 4u);
        const bool shares_exponents = std::string(name) == "sky.hdr";  // eight bits a channel
        for (std::size_t i = 0; i < 32; ++i) {
            const auto channel = [&](std::size_t c) { return float_of_half(world->sky_panorama[4 * i + c]); };
            if (shares_exponents && i == 5) continue;  // the sun takes all the bits
            EXPECT_NEAR(channel(0), 0.25f * float(i), shares_exponents ? 0.04f : 1e-3f) << i;
            EXPECT_NEAR(channel(1), 1.0f, shares_exponents ? 0.04f : 1e-3f) << i;
        }
        EXPECT_EQ(float_of_half(world->sky_panorama[4 * 5 + 2]), 65504.0f) << "the largest half, not infinity";
    }
}

TEST_F(SceneSources, skies_in_eight_bits_are_made_linear) {
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    write_image("sky.png", 4, 2, 3, OIIO::TypeDesc::UINT8, std::vector<std::uint8_t>(4 * 2 * 3, 188));
    const Result<WorldSource> world = load(std::string(kSky) + "\"sky.png\"\n");
    ASSERT_TRUE(world) << error_of(world);
    EXPECT_NEAR(float_of_half(world->sky_panorama[0]), 0.503f, 0.002f);
}

TEST_F(SceneSources, skies_that_are_none_are_errors_that_name_the_file) {
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    write_bytes(folder_ / "text.exr", "this is no picture");
    write_image("square.exr", 4, 4, 3, OIIO::TypeDesc::FLOAT, std::vector<float>(48, 1.0f));
    write_image("whole.exr", 64, 32, 3, OIIO::TypeDesc::FLOAT, std::vector<float>(64 * 32 * 3, 0.7f));
    fs::copy_file(folder_ / "whole.exr", folder_ / "cut.exr");
    fs::resize_file(folder_ / "cut.exr", fs::file_size(folder_ / "cut.exr") / 2);
    for (const char* name : {"text.exr", "square.exr", "cut.exr", "none.exr"}) {
        const Result<WorldSource> world = load(fmt::format("{}\"{}\"\n", kSky, name));
        ASSERT_FALSE(world) << name;
        EXPECT_EQ(world.error().kind, ErrorKind::bad_input);
        EXPECT_NE(error_of(world).find(name), std::string::npos) << error_of(world);
    }
}

TEST_F(SceneSources, a_photographed_sky_is_read) {
    const fs::path sky = shared("hdr/kiara_1_dawn_1k.hdr");
    if (!fs::exists(sky)) GTEST_SKIP() << "no shared content at " << FF_SHARED_DIR;
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    const Result<WorldSource> world = load(fmt::format("{}\"{}\"\n", kSky, sky.string()));
    ASSERT_TRUE(world) << error_of(world);
    EXPECT_EQ(world->environment.panorama_width, 1024u);
    double sum = 0;
    for (const std::uint16_t half : world->sky_panorama) sum += float_of_half(half);
    EXPECT_GT(sum, 0.0);
    EXPECT_TRUE(std::isfinite(sum));
}

constexpr const char* kImageTerrain =
    "[terrain]\nheightmap = \"height.png\"\nsize_m = [160, 80]\nheight_m = [-10, 55.535]\nmax_error_m = 0\n";

TEST_F(SceneSources, a_16_bit_image_spans_the_given_size_and_heights) {
    // Values of a plane: 1000 more a column, 500 more a row; 0.001 m a step.
    std::vector<std::uint16_t> values;
    for (int row = 0; row < 5; ++row)
        for (int column = 0; column < 9; ++column) values.push_back(std::uint16_t(20000 + 1000 * column + 500 * row));
    write_image("height.png", 9, 5, 1, OIIO::TypeDesc::UINT16, values);
    std::optional<cook::GroundFrame> frame;
    const auto field = cook::read_height_file(
        folder_ / "height.png", {.size_m = {{160, 80}}, .height_m = {{-10, 55.535}}, .vertical_scale = 2.0}, frame);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_EQ(field->columns, 9);
    EXPECT_EQ(field->rows, 5);
    EXPECT_NEAR(field->low_x, -80, 1e-9);
    EXPECT_NEAR(field->high_z(), 40, 1e-9);
    for (int row = 0; row < 5; ++row)
        for (int column = 0; column < 9; ++column)
            EXPECT_NEAR(field->at(column, row), 2 * (-10 + 0.001 * (20000 + 1000 * column + 500 * row)), 1e-3);

    const Result<WorldSource> world = load(std::string(kImageTerrain) + "[spawn]\nposition_m = [40, -20]\n");
    ASSERT_TRUE(world) << error_of(world);
    EXPECT_NEAR(world->spawn_position.y, -10 + 0.001 * (20000 + 6000 + 500), 1e-3) << "column 6, row 1";
}

TEST_F(SceneSources, an_image_terrain_needs_its_size_and_heights_and_whole_bytes) {
    write_image("height.png", 3, 3, 1, OIIO::TypeDesc::UINT16, std::vector<std::uint16_t>(9, 7));
    EXPECT_NE(error_of(load("[terrain]\nheightmap = \"height.png\"\nheight_m = [0, 1]\n")).find("size_m"),
              std::string::npos);
    EXPECT_NE(error_of(load("[terrain]\nheightmap = \"height.png\"\nsize_m = [9, 9]\n")).find("height_m"),
              std::string::npos);
    std::vector<std::uint16_t> noise;
    for (std::uint32_t i = 0; i < 64 * 64; ++i) noise.push_back(std::uint16_t(i * 2654435761u >> 16));
    write_image("height.png", 64, 64, 1, OIIO::TypeDesc::UINT16, noise);
    fs::resize_file(folder_ / "height.png", fs::file_size(folder_ / "height.png") / 2);
    const Result<WorldSource> cut = load(kImageTerrain);
    ASSERT_FALSE(cut);
    EXPECT_EQ(cut.error().kind, ErrorKind::bad_input);
    EXPECT_NE(error_of(cut).find("height.png"), std::string::npos) << error_of(cut);
}

// A wood of 0.02 x 0.02 degrees, about 1.5 x 2.2 km, with a clearing in its middle; a pond beside it.
constexpr const char* kWoods = R"({"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"name": "wood"}, "geometry": {"type": "Polygon", "coordinates":
 [[[9.99, 46.99], [10.01, 46.99], [10.01, 47.01], [9.99, 47.01], [9.99, 46.99]],
  [[9.995, 46.995], [9.995, 47.005], [10.005, 47.005], [10.005, 46.995], [9.995, 46.995]]]}}]})";
constexpr const char* kFrame = "[georeference]\nlatitude_deg = 47\nlongitude_deg = 10\n";

// Ground without relief, 6 x 6 km.
constexpr const char* kPlain = "[terrain]\nheightmap = \"plain.asc\"\nsize_m = [6000, 6000]\n";
constexpr const char* kPlainGrid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 3000\n4 4\n4 4\n";

std::vector<DVec3> instances_of(const WorldSource& world) {
    std::vector<DVec3> places;
    for (const Placement& placement : world.placements)
        if (placement.kind == PlacementKind::instance) places.push_back(placement.position);
    return places;
}

void expect_a_wood_with_a_clearing(const WorldSource& world, std::size_t per_km2) {
    const double degree_x = 76057.0, degree_z = 111170.0;  // at 47 N
    const std::vector<DVec3> places = instances_of(world);
    const double area_km2 = 1e-6 * degree_x * degree_z * (0.02 * 0.02 - 0.01 * 0.01);
    EXPECT_NEAR(double(places.size()), area_km2 * double(per_km2), 0.05 * area_km2 * double(per_km2));
    for (const DVec3& p : places) {
        const double x = std::abs(p.x) / degree_x, z = std::abs(p.z) / degree_z;
        ASSERT_LT(std::max(x, z), 0.01 + 1e-4);
        ASSERT_GT(std::max(x, z), 0.005 - 1e-4) << "in the clearing";
        ASSERT_NEAR(p.y, 4.0, 1e-3);
    }
}

TEST_F(SceneSources, woods_grow_within_polygons_and_leave_their_holes_free) {
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    write_bytes(folder_ / "plain.asc", kPlainGrid);
    write_bytes(folder_ / "woods.geojson", kWoods);
    const std::string wood = "[[scatter]]\nfile = \"tree.glb\"\npolygons = \"woods.geojson\"\ndensity_per_km2 = ";
    const Result<WorldSource> world = load(std::string(kFrame) + kPlain + wood + "1000\n");
    ASSERT_TRUE(world) << error_of(world);
    expect_a_wood_with_a_clearing(*world, 1000);
    const Result<WorldSource> absurd = load(std::string(kFrame) + kPlain + wood + "4000000\n");
    ASSERT_FALSE(absurd);
    EXPECT_NE(error_of(absurd).find("4 million"), std::string::npos) << error_of(absurd);
}

// The same wood, a lake with an island as large, and a house, as an OpenStreetMap extract.
std::string osm_extract() {
    std::string nodes, ways;
    int node = 0, way = 0;
    const auto add_way = [&](std::vector<std::pair<double, double>> corners, const std::string& tags) {
        const int first = node + 1;
        std::string refs;
        for (const auto& [lon, lat] : corners) {
            nodes += fmt::format("<node id=\"{}\" lat=\"{}\" lon=\"{}\" version=\"1\"/>\n", ++node, lat, lon);
            refs += fmt::format("<nd ref=\"{}\"/>", node);
        }
        ways += fmt::format("<way id=\"{}\" version=\"1\">{}<nd ref=\"{}\"/>{}</way>\n", ++way, refs, first, tags);
    };
    const auto square = [](double lon, double lat, double half) {
        return std::vector<std::pair<double, double>>{
            {lon - half, lat - half}, {lon + half, lat - half}, {lon + half, lat + half}, {lon - half, lat + half}};
    };
    add_way(square(10, 47, 0.01), "");
    add_way(square(10, 47, 0.005), "");
    add_way(square(10.015, 47, 0.004), "<tag k=\"natural\" v=\"water\"/>");
    add_way({{10, 47}, {10.0002, 47}, {10.0002, 47.0001}, {10, 47.0001}},
            "<tag k=\"building\" v=\"yes\"/><tag k=\"height\" v=\"12\"/><tag k=\"name\" v=\"hut\"/>");
    return "<?xml version=\"1.0\"?>\n<osm version=\"0.6\">\n" + nodes + ways +
           "<relation id=\"1\" version=\"1\"><member type=\"way\" ref=\"1\" role=\"outer\"/>"
           "<member type=\"way\" ref=\"2\" role=\"inner\"/><tag k=\"type\" v=\"multipolygon\"/>"
           "<tag k=\"landuse\" v=\"forest\"/></relation>\n</osm>\n";
}

TEST_F(SceneSources, of_an_openstreetmap_extract_the_woods_are_scattered_on_and_the_buildings_built) {
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    write_bytes(folder_ / "plain.asc", kPlainGrid);
    write_bytes(folder_ / "map.osm", osm_extract());
    const Result<WorldSource> world =
        load(std::string(kFrame) + kPlain + "[[buildings]]\nfootprints = \"map.osm\"\n" +
             "[[scatter]]\nfile = \"tree.glb\"\ndensity_per_km2 = 500\npolygons = \"map.osm\"\n");
    ASSERT_TRUE(world) << error_of(world);
    expect_a_wood_with_a_clearing(*world, 500);
    double highest = 0;
    for (const Placement& placement : world->placements)
        if (placement.kind == PlacementKind::merge)
            for (const Vec3& p : world->meshes[placement.mesh].geometry.positions)
                highest = std::max(highest, placement.position.y + p.y);
    EXPECT_NEAR(highest, 4.0 + 12.0, 1e-3) << "the hut, on the ground";
}

TEST_F(SceneSources, an_extract_without_woods_or_cut_short_is_an_error) {
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    const std::string scene = "[[scatter]]\nfile = \"tree.glb\"\ndensity_per_km2 = 500\npolygons = \"map.osm\"\n";
    std::string bare = osm_extract();
    bare.replace(bare.find("forest"), 6, "meadow");
    for (const std::string& text : {bare, osm_extract().substr(0, 200), std::string("<osm")}) {
        write_bytes(folder_ / "map.osm", text);
        const Result<WorldSource> world = load(kFrame + scene);
        ASSERT_FALSE(world);
        EXPECT_EQ(world.error().kind, ErrorKind::bad_input);
        EXPECT_NE(error_of(world).find("map.osm"), std::string::npos) << error_of(world);
    }
}

TEST_F(SceneSources, a_country_has_its_buildings_and_woods) {
    const fs::path map = shared("city/liechtenstein.osm.pbf");
    if (!fs::exists(map)) GTEST_SKIP() << "no shared content at " << FF_SHARED_DIR;
    write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    write_bytes(folder_ / "plain.asc", kPlainGrid);
    const Result<WorldSource> world = load(
        fmt::format("[georeference]\nlatitude_deg = 47.14\nlongitude_deg = 9.52\n[terrain]\nheightmap = \"plain.asc\"\n"
                    "size_m = [40000, 40000]\n[[buildings]]\nfootprints = \"{0}\"\n"
                    "[[scatter]]\nfile = \"tree.glb\"\npolygons = \"{0}\"\ndensity_per_km2 = 300\n",
                    map.string()));
    ASSERT_TRUE(world) << error_of(world);
    // 160 km2, nearly half of it wooded.
    EXPECT_GT(instances_of(*world).size(), 10'000u);
    EXPECT_LT(instances_of(*world).size(), 40'000u);
    EXPECT_GT(world->meshes.size(), 50u);
}

}  // namespace
}  // namespace ff::test
