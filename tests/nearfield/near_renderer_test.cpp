#include "engine/nearfield/near_renderer.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "engine/farfield/ray_caster.h"
#include "tests/gl/gl_fixture.h"
#include "tests/support/worlds.h"

namespace ff::nearfield {
namespace {

using farfield::VisibilityBuffer;

constexpr int kWidth = 320, kHeight = 240;

std::vector<std::uint32_t> all_instances(const scene::StaticScene& scene) {
    std::vector<std::uint32_t> ids(scene.instances.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

std::vector<farfield::TileRequest> whole_image(const VisibilityBuffer& buffer) {
    std::vector<farfield::TileRequest> tiles;
    for (int y = 0; y < buffer.height; y += farfield::kTileSize) {
        for (int x = 0; x < buffer.width; x += farfield::kTileSize) {
            farfield::TileRequest tile{.x = std::uint16_t(x), .y = std::uint16_t(y)};
            for (auto& row : tile.rows) row = 0xFFFF;
            tiles.push_back(tile);
        }
    }
    return tiles;
}

struct Difference {
    double other_id = 0.0;      ///< share of pixels with another triangle, or sky instead of one
    double other_inside = 0.0;  ///< of these, such whose four neighbours all agree among the caster's ids
    double median_depth = 0.0, worst_depth = 0.0;  ///< relative, where the ids agree
};

/// What a ray caster and the rasteriser see differently.
Difference compare(const scene::StaticScene& scene, const PinholeView& view) {
    VisibilityBuffer cast, drawn;
    cast.resize(view.width, view.height);
    const auto caster = farfield::make_embree_caster(scene);
    caster->cast_tiles(view, whole_image(cast), cast);
    auto renderer = NearRenderer::make(scene);
    EXPECT_TRUE(renderer) << renderer.error().message;
    if (!renderer) return {};
    NearStats stats;
    const Status drawn_status = renderer->render_ids(view, {.instances = all_instances(scene)}, drawn, stats);
    EXPECT_TRUE(drawn_status);

    Difference result;
    std::vector<double> depth_errors;
    const auto same = [&](std::size_t a, std::size_t b) {
        return cast.instance[a] == cast.instance[b] && cast.triangle[a] == cast.triangle[b];
    };
    int others = 0, inside = 0;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const std::size_t i = cast.index(x, y);
            const std::uint32_t expected =
                cast.instance[i] == farfield::kSkyInstance ? farfield::kUnresolved : cast.instance[i];
            if (drawn.instance[i] == expected &&
                (expected == farfield::kUnresolved || drawn.triangle[i] == cast.triangle[i])) {
                if (expected != farfield::kUnresolved)
                    depth_errors.push_back(std::abs(drawn.depth[i] - cast.depth[i]) / cast.depth[i]);
                continue;
            }
            // Two triangles in one place: either may win.
            if (std::abs(drawn.depth[i] - cast.depth[i]) < 1e-5f * cast.depth[i]) continue;
            ++others;
            const bool border = x == 0 || y == 0 || x == view.width - 1 || y == view.height - 1;
            const auto stride = std::size_t(cast.stride);
            if (!border && same(i, i - 1) && same(i, i + 1) && same(i, i - stride) && same(i, i + stride)) ++inside;
        }
    }
    result.other_id = double(others) / (view.width * view.height);
    result.other_inside = double(inside) / (view.width * view.height);
    if (!depth_errors.empty()) {
        std::sort(depth_errors.begin(), depth_errors.end());
        result.median_depth = depth_errors[depth_errors.size() / 2];
        result.worst_depth = depth_errors.back();
    }
    ::testing::Test::RecordProperty("other_id_ppm", int(1e6 * result.other_id));
    fmt::print(stderr, "other ids {:.5f}, inside {:.6f}, depth median {:.2e} worst {:.2e}\n", result.other_id,
               result.other_inside, result.median_depth, result.worst_depth);
    return result;
}

PinholeView street_view(const WorldPos& origin = WorldPos(0.0), double yaw = 0.4, double pitch = -0.05) {
    return make_view({.position = origin + DVec3(3.0, 1.7, 5.0), .yaw = yaw, .pitch = pitch}, kWidth, kHeight);
}

using NearRendererTest = test::GlTest;

TEST_F(NearRendererTest, ids_are_the_casters_own_except_at_edges_in_a_city) {
    const scene::SceneData world = test::make_city({.cells = 3, .subdivisions = 4});
    const Difference difference = compare(world.view(), street_view());
    EXPECT_LT(difference.other_id, 0.002);
    EXPECT_EQ(difference.other_inside, 0.0);
    EXPECT_LT(difference.median_depth, 1e-5);
}

TEST_F(NearRendererTest, ids_stay_the_casters_own_a_thousand_kilometres_from_the_origin) {
    const WorldPos origin(1.0e6, 0.0, -1.0e6);
    const scene::SceneData world = test::make_city({.cells = 3, .subdivisions = 4}, {.origin = origin});
    const Difference difference = compare(world.view(), street_view(origin));
    EXPECT_LT(difference.other_id, 0.002);
    EXPECT_EQ(difference.other_inside, 0.0);
}

TEST_F(NearRendererTest, ids_are_the_casters_own_for_any_camera_in_triangle_soup) {
    const scene::SceneData world = test::make_triangle_soup({.triangles = 200, .meshes = 3});
    test::Random random(7);
    for (int i = 0; i < 4; ++i) {
        const Camera camera = test::random_camera(random, world.bounds);
        SCOPED_TRACE(i);
        const Difference difference = compare(world.view(), make_view(camera, kWidth, kHeight));
        EXPECT_LT(difference.other_id, 0.01);
    }
}

TEST_F(NearRendererTest, masked_leaves_are_where_the_casters_see_them) {
    const scene::SceneData world = test::make_forest({.trees = 100, .size_m = 80.0});
    const Difference difference = compare(world.view(), street_view());
    EXPECT_LT(difference.other_id, 0.03);  // texels' borders: interpolated coordinates differ in their last bits
}

TEST_F(NearRendererTest, terrain_is_seen_alike_to_the_horizon) {
    const scene::SceneData world = test::make_terrain();
    const double ground = test::terrain_height(3.0, 5.0, 80.0);
    const Difference difference = compare(world.view(), street_view({0.0, ground, 0.0}));
    EXPECT_LT(difference.other_id, 0.003);
}

TEST_F(NearRendererTest, dynamic_instances_appear_under_their_own_ids) {
    const scene::SceneData world = test::make_single_triangle({-1, -1, -5}, {1, -1, -5}, {0, 1, -5});
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    std::vector<scene::Instance> dynamic(1, scene.instances[0]);
    dynamic[0].position += DVec3(0.0, 0.0, 2.0);  // in front of the static one
    const std::uint32_t ids[] = {0, 1};
    VisibilityBuffer buffer;
    NearStats stats;
    ASSERT_TRUE(renderer->render_ids(make_view({}, 64, 64), {.instances = ids, .dynamic = dynamic}, buffer, stats));
    EXPECT_EQ(buffer.instance[buffer.index(32, 32)], 1u);
    EXPECT_NEAR(buffer.depth[buffer.index(32, 32)], 3.0, 1e-4);
    EXPECT_EQ(buffer.instance[buffer.index(0, 0)], farfield::kUnresolved);
    EXPECT_TRUE(std::isinf(buffer.depth[buffer.index(0, 0)]));
    EXPECT_EQ(stats.triangles, 2u);
}

TEST_F(NearRendererTest, an_empty_set_leaves_every_pixel_unresolved) {
    const scene::SceneData world = test::make_empty_world();
    auto renderer = NearRenderer::make(world.view());
    ASSERT_TRUE(renderer) << renderer.error().message;
    VisibilityBuffer buffer;
    NearStats stats;
    ASSERT_TRUE(renderer->render_ids(make_view({}, 33, 17), {}, buffer, stats));
    for (int y = 0; y < 17; ++y)
        for (int x = 0; x < 33; ++x) EXPECT_EQ(buffer.instance[buffer.index(x, y)], farfield::kUnresolved);
    shading::Image image;
    EXPECT_TRUE(renderer->render_shaded(make_view({}, 33, 17), {}, image, stats));
}

TEST_F(NearRendererTest, a_view_too_large_for_the_driver_is_refused) {
    const scene::SceneData world = test::make_empty_world();
    auto renderer = NearRenderer::make(world.view());
    ASSERT_TRUE(renderer) << renderer.error().message;
    PinholeView view = make_view({}, 16, 16);
    view.width = 1 << 20;
    shading::Image image;
    NearStats stats;
    const Status status = renderer->render_shaded(view, {}, image, stats);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("1048576x16"), std::string::npos);
}

/// Share of pixels where the rasterised picture and the shading pass over the casters' ids differ by more than
/// `tolerance` of 255 in some channel.
double shading_difference(const scene::StaticScene& scene, const PinholeView& view, int tolerance) {
    VisibilityBuffer cast;
    cast.resize(view.width, view.height);
    const auto tiles = whole_image(cast);
    farfield::make_embree_caster(scene)->cast_tiles(view, tiles, cast);
    shading::Image expected, drawn;
    expected.resize(view.width, view.height);
    shading::shade_tiles(scene, {}, view, cast, tiles, {}, expected);
    auto renderer = NearRenderer::make(scene);
    EXPECT_TRUE(renderer) << renderer.error().message;
    if (!renderer) return 1.0;
    NearStats stats;
    EXPECT_TRUE(renderer->render_shaded(view, {.instances = all_instances(scene)}, drawn, stats));
    int others = 0;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const std::uint32_t a = expected.pixels[std::size_t(y * expected.stride + x)];
            const std::uint32_t b = drawn.pixels[std::size_t(y * drawn.stride + x)];
            int worst = 0;
            for (int shift = 0; shift < 24; shift += 8)
                worst = std::max(worst, std::abs(int(a >> shift & 255u) - int(b >> shift & 255u)));
            others += worst > tolerance;
        }
    }
    const double share = double(others) / (view.width * view.height);
    fmt::print(stderr, "shading differs on {:.5f}\n", share);
    return share;
}

TEST_F(NearRendererTest, the_shaded_picture_is_the_shading_passes_except_at_edges_in_a_city) {
    const scene::SceneData world = test::make_city({.cells = 3, .subdivisions = 4});
    EXPECT_LT(shading_difference(world.view(), street_view(), 3), 0.004);
}

TEST_F(NearRendererTest, the_shaded_picture_is_the_shading_passes_except_at_leaves_in_a_forest) {
    const scene::SceneData world = test::make_forest({.trees = 100, .size_m = 80.0});
    EXPECT_LT(shading_difference(world.view(), street_view(), 3), 0.04);
}

TEST_F(NearRendererTest, the_shaded_picture_is_the_same_every_time) {
    const scene::SceneData world = test::make_forest({.trees = 100, .size_m = 80.0});
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    shading::Image first, second;
    NearStats stats;
    const auto ids = all_instances(scene);
    ASSERT_TRUE(renderer->render_shaded(street_view(), {.instances = ids}, first, stats));
    ASSERT_TRUE(renderer->render_shaded(street_view(), {.instances = ids}, second, stats));
    EXPECT_EQ(first.pixels, second.pixels);
}

}  // namespace
}  // namespace ff::nearfield
