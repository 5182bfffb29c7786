// The opacity buffer against its plain reference: never a pixel that no triangle covers, and few missed.
#include "engine/farfield/opacity_buffer.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

std::vector<std::uint32_t> all_of(const scene::StaticScene& scene) {
    std::vector<std::uint32_t> ids(scene.instances.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

struct Compared {
    std::uint64_t covered = 0;  ///< by the reference
    std::uint64_t missed = 0;
    std::uint64_t holes = 0;  ///< drawn, but not covered
};

Compared compare(const scene::StaticScene& scene, const PinholeView& view, const OpacitySettings& settings = {}) {
    PixelMask fast, plain;
    OpacityRaster raster(settings);
    raster.draw(scene, {}, all_of(scene), view, fast);
    draw_opacity_reference(scene, {}, all_of(scene), view, double(settings.near_plane_m), plain);
    Compared result;
    for (std::size_t tile = 0; tile < fast.tiles.size(); ++tile)
        for (int j = 0; j < kTileSize; ++j) {
            const unsigned a = fast.tiles[tile].rows[j], b = plain.tiles[tile].rows[j];
            result.covered += std::uint64_t(std::popcount(b));
            result.missed += std::uint64_t(std::popcount(b & ~a));
            result.holes += std::uint64_t(std::popcount(a & ~b));
        }
    return result;
}

TEST(OpacityBuffer, never_covers_what_the_reference_leaves_open_in_triangle_soups) {
    Compared sum;
    for (std::uint32_t seed = 0; seed < 150; ++seed) {
        SCOPED_TRACE(seed);
        test::Random random(seed);
        const WorldPos origin = seed % 5 == 0 ? WorldPos(1e6, 50.0, -7e5) : WorldPos(0.0);
        // From dust to triangles that reach from behind the eye to far outside the image; slivers always among them.
        const double edge = std::pow(10.0, random.in(-1.5, 2.0));
        const scene::SceneData world =
            test::make_triangle_soup({.triangles = 150, .size_m = 20.0, .edge_m = edge, .masked = seed % 4 == 3},
                                     {.seed = seed, .origin = origin});
        DBox3 around;
        around.add(origin - 14.0);
        around.add(origin + 14.0);
        const PinholeView view =
            make_view(test::random_camera(random, around), 150 + int(seed % 40), 100 + int(seed % 7));
        const Compared result = compare(world.view(), view, {.near_plane_m = seed % 2 ? 0.1f : 0.5f});
        EXPECT_EQ(result.holes, 0u);
        sum.covered += result.covered;
        sum.missed += result.missed;
    }
    EXPECT_GT(sum.covered, 100000u);
    EXPECT_LT(double(sum.missed), 0.02 * double(sum.covered));
}

TEST(OpacityBuffer, covers_nearly_all_of_a_street_and_nothing_else) {
    const scene::SceneData world = test::make_city({.cells = 3, .subdivisions = 3});
    Compared sum;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        SCOPED_TRACE(seed);
        test::Random random(seed);
        Camera camera = test::random_camera(random, world.bounds);
        camera.position.y = random.in(1.0, 40.0);
        camera.pitch *= 0.2;
        const Compared result = compare(world.view(), make_view(camera, 320, 240));
        EXPECT_EQ(result.holes, 0u);
        sum.covered += result.covered;
        sum.missed += result.missed;
    }
    EXPECT_LT(double(sum.missed), 0.01 * double(sum.covered));
}

TEST(OpacityBuffer, masked_triangles_never_count) {
    const scene::SceneData world = test::make_forest({.trees = 60, .size_m = 60.0, .masked = true, .leaves = 60});
    for (std::uint32_t seed = 0; seed < 5; ++seed) {
        test::Random random(seed);
        Camera camera = test::random_camera(random, world.bounds);
        EXPECT_EQ(compare(world.view(), make_view(camera, 160, 120)).holes, 0u);
    }
}

TEST(OpacityBuffer, one_triangle_before_the_whole_image_fills_every_tile) {
    const scene::SceneData world =
        test::make_single_triangle(Vec3(-900, -900, -3), Vec3(900, -900, -3), Vec3(0, 900, -3));
    PixelMask covered;
    OpacityRaster raster;
    const PinholeView view = make_view({}, 201, 133);  // cut tiles at both borders
    raster.draw(world.view(), {}, all_of(world.view()), view, covered);
    EXPECT_EQ(covered.count(), 201u * 133u);
    std::vector<TileRequest> requests;
    EXPECT_EQ(list_uncovered(covered, nullptr, requests), 0u);
    EXPECT_TRUE(requests.empty());
}

TEST(OpacityBuffer, a_triangle_nearer_than_the_near_plane_covers_nothing) {
    const scene::SceneData world =
        test::make_single_triangle(Vec3(-9, -9, -0.05f), Vec3(9, -9, -0.05f), Vec3(0, 9, -0.05f));
    PixelMask covered;
    OpacityRaster raster({.near_plane_m = 0.1f});
    raster.draw(world.view(), {}, all_of(world.view()), make_view({}, 64, 64), covered);
    EXPECT_EQ(covered.count(), 0u);
}

TEST(OpacityBuffer, dynamic_instances_are_named_by_the_ids_after_the_static_ones) {
    const scene::SceneData world = test::make_single_triangle(Vec3(-9, -9, 3), Vec3(9, -9, 3), Vec3(0, 9, 3));
    scene::Instance moved = world.instances[0];
    moved.position = {0.0, 0.0, -10.0};
    PixelMask covered;
    OpacityRaster raster;
    const std::uint32_t only_static[] = {0}, both[] = {0, 1};
    raster.draw(world.view(), {&moved, 1}, only_static, make_view({}, 64, 64), covered);
    EXPECT_EQ(covered.count(), 0u);
    raster.draw(world.view(), {&moved, 1}, both, make_view({}, 64, 64), covered);
    EXPECT_GT(covered.count(), 1000u);
}

TEST(OpacityBuffer, from_depth_takes_either_convention_and_either_row_order) {
    constexpr int kWidth = 37, kHeight = 21;
    test::Random random(3);
    std::vector<float> distance(kWidth * kHeight), reversed(kWidth * kHeight);
    std::uint64_t expected = 0;
    for (std::size_t i = 0; i < distance.size(); ++i) {
        const bool drawn = random.unit() < 0.4;
        expected += drawn ? 1 : 0;
        distance[i] = drawn ? float(random.in(0.1, 5000.0)) : std::numeric_limits<float>::infinity();
        reversed[i] = drawn ? 0.1f / distance[i] : 0.0f;
    }
    PixelMask a, b, flipped;
    opacity_from_depth(distance.data(), kWidth, kWidth, kHeight, EmptyDepth::infinite, a);
    opacity_from_depth(reversed.data(), kWidth, kWidth, kHeight, EmptyDepth::zero, b);
    opacity_from_depth(distance.data() + kWidth * (kHeight - 1), -kWidth, kWidth, kHeight, EmptyDepth::infinite,
                       flipped);
    EXPECT_EQ(a.count(), expected);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            ASSERT_EQ(a.test(x, y), b.test(x, y));
            ASSERT_EQ(a.test(x, y), flipped.test(x, kHeight - 1 - y));
        }
    std::vector<TileRequest> requests;
    EXPECT_EQ(list_uncovered(a, nullptr, requests), kWidth * kHeight - expected);
    PixelMask sky;
    sky.reset(kWidth, kHeight);
    for (int x = 0; x < kWidth; ++x) sky.set(x, 0);
    std::uint64_t both = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) both += a.test(x, y) || y == 0 ? 1 : 0;
    EXPECT_EQ(list_uncovered(a, &sky, requests), kWidth * kHeight - both);
}

TEST(OpacityBuffer, an_empty_view_and_an_empty_world_are_empty) {
    const scene::SceneData world = test::make_empty_world();
    PixelMask covered;
    OpacityRaster raster;
    raster.draw(world.view(), {}, {}, make_view({}, 40, 30), covered);
    EXPECT_EQ(covered.count(), 0u);
    PinholeView none = make_view({}, 40, 30);
    none.width = none.height = 0;
    raster.draw(world.view(), {}, {}, none, covered);
    EXPECT_TRUE(covered.tiles.empty());
}

}  // namespace
}  // namespace ff::farfield
