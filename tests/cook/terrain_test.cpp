#include "tools/cook/terrain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>

#include "tests/support/temporary_folder.h"
#include "tools/cook/terrain_valley.h"

namespace ff::cook {
namespace {

namespace fs = std::filesystem;

HeightField bumpy(int columns, int rows, std::uint64_t seed) {
    HeightField field{
        .low_x = -300, .low_z = -200, .spacing_x = 7, .spacing_z = 5, .columns = columns, .rows = rows, .heights = {}};
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            field.heights.push_back(float(40 * fractal_noise(seed, i * 0.07, j * 0.06, 5)));
    return field;
}

std::size_t triangle_count(const WorldSource& world) {
    std::size_t count = 0;
    for (const SourceMesh& mesh : world.meshes) count += mesh.geometry.triangle_materials.size();
    return count;
}

TEST(Terrain, keeps_to_its_error_bound_at_every_sample) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        const HeightField field = bumpy(40 + int(seed) * 13, 90 - int(seed) * 7, seed);
        for (const double bound : {0.0, 0.5, 3.0}) {
            const Terrain terrain(field, bound);
            for (int j = 0; j < field.rows; ++j)
                for (int i = 0; i < field.columns; ++i) {
                    const std::optional<double> y =
                        terrain.height_at(field.low_x + i * field.spacing_x, field.low_z + j * field.spacing_z);
                    ASSERT_TRUE(y);
                    ASSERT_NEAR(*y, field.at(i, j), bound + 1e-3) << "seed " << seed << " at " << i << ", " << j;
                }
        }
    }
}

// Every inner edge belongs to two triangles, in opposite directions: no T-junctions, hence no cracks.
TEST(Terrain, has_no_cracks) {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const HeightField field = bumpy(61 + int(seed) * 9, 70, seed);
        WorldSource world;
        Terrain(field, 1.0, std::vector<RectXZ>{{-100, -50, 20, 40}}).add_to(world, {}, 16);
        using Point = std::pair<long, long>;
        std::map<std::pair<Point, Point>, int> edges;
        double area = 0;
        for (const Placement& placement : world.placements) {
            const scene::MeshSource& mesh = world.meshes[placement.mesh].geometry;
            for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
                DVec3 p[3];
                for (std::size_t k = 0; k < 3; ++k)
                    p[k] = placement.position + DVec3(mesh.positions[mesh.indices[t + k]]);
                const double up = glm::cross(p[1] - p[0], p[2] - p[0]).y;
                ASSERT_GT(up, 0.0);
                area += 0.5 * up;
                for (int k = 0; k < 3; ++k) {
                    const auto key = [](const DVec3& q) { return Point(std::lround(q.x * 10), std::lround(q.z * 10)); };
                    ++edges[{key(p[k]), key(p[(k + 1) % 3])}];
                }
            }
        }
        EXPECT_NEAR(area, (field.high_x() - field.low_x) * (field.high_z() - field.low_z), 1.0);
        const auto on_border = [&](const Point& a, const Point& b) {
            const auto same = [&](double x, long u, long v) { return u == v && std::abs(double(u) / 10 - x) < 0.2; };
            return same(field.low_x, a.first, b.first) || same(field.high_x(), a.first, b.first) ||
                   same(field.low_z, a.second, b.second) || same(field.high_z(), a.second, b.second);
        };
        for (const auto& [edge, count] : edges) {
            ASSERT_EQ(count, 1);
            if (!on_border(edge.first, edge.second)) {
                ASSERT_TRUE(edges.contains({edge.second, edge.first}));
            }
        }
    }
}

TEST(Terrain, flat_ground_costs_next_to_nothing) {
    HeightField field{.spacing_x = 10, .spacing_z = 10, .columns = 1025, .rows = 1025, .heights = {}};
    field.heights.assign(1025 * 1025, 3.0f);
    WorldSource world;
    Terrain(field, 0.1).add_to(world, {});
    EXPECT_EQ(triangle_count(world), 2u);
}

TEST(Terrain, the_mesh_is_what_height_at_says) {
    const HeightField field = bumpy(65, 65, 3);
    const Terrain terrain(field, 1.5);
    WorldSource world;
    terrain.add_to(world, {}, 32);
    for (const Placement& placement : world.placements) {
        const scene::MeshSource& mesh = world.meshes[placement.mesh].geometry;
        for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
            DVec3 middle(0.0);
            for (std::size_t k = 0; k < 3; ++k)
                middle += (placement.position + DVec3(mesh.positions[mesh.indices[t + k]])) / 3.0;
            ASSERT_NEAR(terrain.height_at(middle.x, middle.z).value_or(1e9), middle.y, 1e-3);
        }
    }
    EXPECT_FALSE(terrain.height_at(field.high_x() + 1, 0));
}

class TerrainFile : public testing::Test {
  protected:
    fs::path write(const std::string& name, const std::string& text) const {
        const fs::path path = folder_ / name;
        std::ofstream(path, std::ios::binary) << text;
        return path;
    }
    static fs::path shared(const char* name) { return fs::path(FF_SHARED_DIR) / "content/terrain" / name; }
    test::TemporaryFolder folder_;
    std::optional<GroundFrame> frame_;
};

TEST_F(TerrainFile, an_ascii_grid_lies_around_the_origin_and_its_voids_are_filled) {
    const fs::path path = write("small.asc",
                                "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n"
                                "1 2 3\n4 -9999 6\n7 8 9\n");
    const Result<HeightField> field = read_height_file(path, {}, frame_);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_EQ(field->columns, 3);
    EXPECT_NEAR(field->low_x, -10, 1e-9);
    EXPECT_NEAR(field->high_z(), 10, 1e-9);
    EXPECT_EQ(field->at(0, 0), 1.0f);
    EXPECT_EQ(field->at(2, 2), 9.0f);
    EXPECT_NEAR(field->at(1, 1), 5.0, 3.0);
}

TEST_F(TerrainFile, what_is_no_raster_or_holds_only_voids_is_an_error) {
    const auto error = [&](const fs::path& path, const HeightFileSettings& settings = {}) {
        const Result<HeightField> field = read_height_file(path, settings, frame_);
        return field ? std::string() : field.error().message;
    };
    EXPECT_NE(error(write("bad.tif", "not a picture")).find("not a raster"), std::string::npos);
    EXPECT_NE(error(write("void.asc",
                          "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -1\n-1 -1\n-1 -1\n"))
                  .find("only voids"),
              std::string::npos);
    EXPECT_NE(error(folder_ / "none.tif").find("no such file"), std::string::npos);
}

TEST_F(TerrainFile, srtm_tiles_span_a_degree_and_have_no_voids) {
    if (!fs::exists(shared("N42E001.hgt"))) GTEST_SKIP() << "no shared content at " << FF_SHARED_DIR;
    const Result<HeightField> field = read_height_file(shared("N42E001.hgt"), {.spacing_m = 200}, frame_);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_NEAR(frame_->latitude_deg, 42.5, 0.01);
    EXPECT_NEAR(frame_->longitude_deg, 1.5, 0.01);
    EXPECT_NEAR(field->high_x() - field->low_x, 81500, 1500);  // the northern edge, the shorter one
    EXPECT_NEAR(field->high_z() - field->low_z, 111000, 1500);
    for (const float y : field->heights) ASSERT_TRUE(y > 200 && y < 3200) << y;
}

TEST_F(TerrainFile, projected_rasters_are_warped_to_the_plane) {
    if (!fs::exists(shared("bigtujunga.tif"))) GTEST_SKIP() << "no shared content at " << FF_SHARED_DIR;
    const Result<HeightField> field = read_height_file(shared("bigtujunga.tif"), {}, frame_);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_NEAR(frame_->latitude_deg, 34.3, 0.3);
    EXPECT_NEAR(frame_->longitude_deg, -118.2, 0.5);
    float low = 1e9f, high = -1e9f;
    for (const float y : field->heights) low = std::min(low, y), high = std::max(high, y);
    EXPECT_GT(low, 0.0f);
    EXPECT_GT(high, low + 500.0f);
    // A frame far away is told.
    std::optional<GroundFrame> elsewhere = GroundFrame{-40.0, 100.0};
    EXPECT_FALSE(read_height_file(shared("bigtujunga.tif"), {}, elsewhere));
}

TEST_F(TerrainFile, grids_without_coordinates_open_and_colour_pictures_do_not) {
    if (!fs::exists(shared("hugo_site_filled.asc"))) GTEST_SKIP() << "no shared content at " << FF_SHARED_DIR;
    EXPECT_TRUE(read_height_file(shared("hugo_site_filled.asc"), {}, frame_));
    const Result<HeightField> colour = read_height_file(shared("terrarium_256.png"), {}, frame_);
    ASSERT_FALSE(colour);
    EXPECT_NE(colour.error().message.find("channels"), std::string::npos) << colour.error().message;
}

}  // namespace
}  // namespace ff::cook
