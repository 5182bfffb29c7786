#include "engine/scene/scene_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/scene/texel_address.h"
#include "tests/support/worlds.h"

namespace ff::scene {
namespace {

TEST(Normals, SurviveThePackingToAFewThousandthsOfADegree) {
    test::Random random(1);
    double worst = 0.0;
    for (int i = 0; i < 100000; ++i) {
        const Vec3 n = glm::normalize(random.in_box(Vec3(-1.0f), Vec3(1.0f)));
        std::int16_t oct[2];
        encode_normal(n, oct);
        const DVec3 back(decode_normal(oct));
        worst = std::max(worst, degrees_of(std::asin(std::min(1.0, glm::length(glm::cross(DVec3(n), back))))));
        ASSERT_GT(glm::dot(DVec3(n), back), 0.9);
    }
    EXPECT_LT(worst, 0.004);
}

TEST(Normals, OfNothingPointUp) {
    std::int16_t oct[2];
    for (const Vec3& n : {Vec3(0.0f), Vec3(NAN, 0.0f, 0.0f), Vec3(INFINITY, 0.0f, 0.0f)}) {
        encode_normal(n, oct);
        EXPECT_NEAR(decode_normal(oct).y, 1.0f, 1e-3f);
    }
}

TEST(TextureMips, AreAveragesInLinearLightDownToOneTexel) {
    SceneData scene;
    // A checker of black and white: half the light is sRGB 188, not 128.
    std::vector<std::uint32_t> checker(16 * 4);
    for (std::size_t i = 0; i < checker.size(); ++i) checker[i] = (i + i / 16) % 2 == 0 ? 0xFFFFFFFFu : 0xFF000000u;
    const std::uint32_t id = scene.add_texture(checker, 16, 4, Wrap::repeat, Wrap::repeat);
    const Texture& texture = scene.textures[id];
    EXPECT_EQ(texture.level_count, 5u);
    EXPECT_EQ(scene.texels.size(), 16u * 4 + 8 * 2 + 4 + 2 + 1);
    for (std::uint32_t level = 1; level < texture.level_count; ++level)
        EXPECT_EQ(scene.texels[level_offset(texture, level)], 0xFFBCBCBCu) << level;
}

TEST(TextureMips, KeepTheCoverageOfAMask) {
    SceneData scene;
    test::add_leaf_material(scene, 256);
    const Texture& texture = scene.textures[0];
    const auto coverage = [&](std::uint32_t level) {
        const std::size_t count = std::size_t(texture.width >> level) * (texture.height >> level);
        std::size_t covered = 0;
        for (std::size_t i = 0; i < count; ++i)
            covered += (scene.texels[level_offset(texture, level) + i] >> 24) >= 128;
        return double(covered) / double(count);
    };
    for (std::uint32_t level = 1; level < 6; ++level) EXPECT_NEAR(coverage(level), coverage(0), 0.03) << level;
}

TEST(TextureMips, AreNotTintedByWhatIsCutAway) {
    SceneData scene;
    std::vector<std::uint32_t> texels(64, 0x000000FFu);               // red, invisible
    for (std::size_t i = 0; i < 64; i += 2) texels[i] = 0xFF00FF00u;  // green, there
    scene.add_texture(texels, 8, 8, Wrap::clamp, Wrap::clamp);
    EXPECT_EQ(scene.texels.back() & 0xFFFFFFu, 0x00FF00u);
}

TEST(SceneData, FinishSortsInstancesByCellAndBoundsThem) {
    const SceneData scene = test::make_forest({.trees = 100});
    ASSERT_FALSE(scene.cells.empty());
    std::uint32_t next = 0;
    std::uint64_t triangles = 0;
    for (std::size_t c = 0; c < scene.cells.size(); ++c) {
        const Cell& cell = scene.cells[c];
        ASSERT_EQ(cell.first_instance, next);
        next += cell.instance_count;
        for (std::uint32_t i = 0; i < cell.instance_count; ++i) {
            const Instance& instance = scene.instances[cell.first_instance + i];
            EXPECT_EQ(instance.cell, c);
            EXPECT_GE(instance.bounds.low.x, cell.bounds.low.x);
            EXPECT_LE(instance.bounds.high.z, cell.bounds.high.z);
            const Mesh& mesh = scene.meshes[instance.mesh];
            triangles += mesh.triangle_count;
            for (std::uint32_t v = 0; v < mesh.vertex_count; ++v) {
                const DVec3 p =
                    instance.position + DMat3(instance.world_from_mesh) * DVec3(scene.positions[mesh.first_vertex + v]);
                ASSERT_LE(distance_to(instance.bounds, p), 1e-9);
            }
        }
    }
    EXPECT_EQ(next, scene.instances.size());
    std::uint64_t sum = 0;
    for (const Cell& cell : scene.cells) sum += cell.triangle_count;
    EXPECT_EQ(sum, triangles);
}

TEST(SceneData, InstanceBvhHoldsEveryInstanceOnceInABoxThatEnclosesIt) {
    const SceneData scene = test::make_forest({.trees = 500}, {.origin = WorldPos(1e6, 0.0, -2e6)});
    std::vector<int> seen(scene.instances.size(), 0);
    for (const BvhNode& node : scene.instance_nodes) {
        for (int lane = 0; lane < kBvhWidth; ++lane) {
            if (node.child[lane] == kBvhEmpty || !(node.child[lane] & kBvhLeafBit)) continue;
            const std::uint32_t id = node.child[lane] & ~kBvhLeafBit;
            ++seen[id];
            const DBox3& bounds = scene.instances[id].bounds;
            EXPECT_LE(double(node.low_x[lane]), bounds.low.x - scene.origin.x);
            EXPECT_GE(double(node.high_x[lane]), bounds.high.x - scene.origin.x);
            EXPECT_LE(double(node.low_z[lane]), bounds.low.z - scene.origin.z);
            EXPECT_GE(double(node.high_z[lane]), bounds.high.z - scene.origin.z);
        }
    }
    for (const int count : seen) EXPECT_EQ(count, 1);
}

TEST(SceneData, OfAnEmptyWorldIsEmpty) {
    const SceneData scene = test::make_empty_world();
    EXPECT_TRUE(scene.bounds.is_empty());
    EXPECT_TRUE(scene.instance_nodes.empty());
    EXPECT_EQ(scene.height_grid.size, 0u);
}

TEST(HeightGrid, IsAnUpperBoundOfEveryPointOnEveryTriangle) {
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        const SceneData scene =
            seed % 3 == 0 ? test::make_terrain({.size_m = 600, .spacing_m = 30}, {.seed = seed})
            : seed % 3 == 1
                ? test::make_triangle_soup({.triangles = 60, .edge_m = 15.0}, {.seed = seed, .height_grid_size = 64})
                : test::make_forest({.trees = 30, .leaves = 50}, {.seed = seed, .height_grid_size = 64});
        const HeightGrid grid = scene.view().height_grid;
        test::Random random(seed);
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[instance.mesh];
            for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
                for (int sample = 0; sample < 20; ++sample) {
                    double b1 = random.unit(), b2 = random.unit();
                    if (b1 + b2 > 1.0) b1 = 1.0 - b1, b2 = 1.0 - b2;
                    const double b[3] = {1.0 - b1 - b2, b1, b2};
                    DVec3 p = instance.position;
                    for (std::size_t k = 0; k < 3; ++k) {
                        const std::uint32_t v = scene.indices[3 * (mesh.first_triangle + t) + k];
                        p += b[k] * (DMat3(instance.world_from_mesh) * DVec3(scene.positions[mesh.first_vertex + v]));
                    }
                    const auto x = std::size_t((p.x - grid.low_x) / grid.square_m);
                    const auto z = std::size_t((p.z - grid.low_z) / grid.square_m);
                    ASSERT_LT(std::max(x, z), grid.size);
                    ASSERT_GE(double(grid.heights[z * grid.size + x]) + 1e-5, p.y - grid.base_y) << "seed " << seed;
                }
            }
        }
    }
}

TEST(HeightGrid, IsTightOnATerrainAndItsMipsAreMaxima) {
    const SceneData scene = test::make_terrain({.size_m = 2000, .spacing_m = 10}, {.height_grid_size = 64});
    const HeightGrid grid = scene.view().height_grid;
    double excess = 0.0;
    for (std::size_t z = 0; z < grid.size; ++z) {
        for (std::size_t x = 0; x < grid.size; ++x) {
            double top = -1e9;
            for (int j = 0; j <= 8; ++j) {
                for (int i = 0; i <= 8; ++i) {
                    const double wx = grid.low_x + (double(x) + i / 8.0) * grid.square_m;
                    const double wz = grid.low_z + (double(z) + j / 8.0) * grid.square_m;
                    top = std::max(top, test::terrain_height(wx, wz, 80.0));
                }
            }
            excess += double(grid.heights[z * grid.size + x]) + grid.base_y - top;
        }
    }
    EXPECT_LT(excess / double(grid.size * grid.size), 1.0);
    const float* fine = grid.heights.data();
    for (std::size_t size = grid.size; size > 1; size /= 2) {
        const float* coarse = fine + size * size;
        for (std::size_t i = 0; i < size * size; ++i) {
            const std::size_t x = i % size, z = i / size;
            ASSERT_GE(coarse[(z / 2) * (size / 2) + x / 2], fine[i]);
        }
        fine = coarse;
    }
    EXPECT_NEAR(double(*fine), scene.bounds.extent().y, 0.1);
}

TEST(PrelitColors, AreTheMeanColourOfATriangle) {
    SceneData scene;
    scene.materials.push_back({.base_color = Vec4(0.5f, 1.0f, 0.25f, 1.0f)});
    MeshSource mesh;
    test::append_triangle(mesh, Vec3(0.0f), Vec3(1.0f, 0.0f, 0.0f), Vec3(0.0f, 1.0f, 0.0f), 0);
    scene.add_instance(scene.add_mesh(prepare_mesh(mesh, scene.materials)), WorldPos(0.0), Mat3(1.0f), 0);
    scene.finish(16);
    ASSERT_EQ(scene.prelit_colors.size(), 1u);
    EXPECT_EQ(scene.prelit_colors[0], 0xFF40FF80u);
}

}  // namespace
}  // namespace ff::scene
