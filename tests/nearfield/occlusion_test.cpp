#include <gtest/gtest.h>

#include "engine/nearfield/near_renderer.h"
#include "engine/visibility/culler.h"
#include "tests/gl/gl_fixture.h"
#include "tests/support/worlds.h"

namespace ff::nearfield {
namespace {

constexpr int kWidth = 320, kHeight = 240;

using OcclusionTest = test::GlTest;

/// Draws random views of a world with and without culling by occlusion.
/// @return triangles left out, of all views
std::uint64_t expect_same_ids(const scene::SceneData& world, const DBox3& cameras, int views) {
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    EXPECT_TRUE(renderer) << renderer.error().message;
    if (!renderer) return 0;
    const visibility::Culler culler(scene);
    test::Random random(3);
    std::uint64_t hidden = 0;
    for (int i = 0; i < views; ++i) {
        SCOPED_TRACE(i);
        Camera camera = test::random_camera(random, cameras);
        camera.pitch *= 0.3;
        const PinholeView view = make_view(camera, kWidth, kHeight);
        visibility::VisibleSet visible;
        culler.cull(view, {}, visible);
        const DrawSet set{.instances = visible.instances};
        farfield::VisibilityBuffer all, culled;
        NearStats all_stats, culled_stats, again_stats;
        renderer->set_occlusion({.enabled = false});
        EXPECT_TRUE(renderer->render_ids(view, set, all, all_stats));
        renderer->set_occlusion({.price_triangles = 0});  // always split
        EXPECT_TRUE(renderer->render_ids(view, set, culled, culled_stats));
        EXPECT_TRUE(renderer->render_ids(view, set, culled, again_stats));
        EXPECT_EQ(all.instance, culled.instance);
        EXPECT_EQ(all.triangle, culled.triangle);
        EXPECT_EQ(all.depth, culled.depth);
        EXPECT_EQ(all_stats.hidden_triangles, 0u);
        EXPECT_EQ(culled_stats.triangles + culled_stats.hidden_triangles, all_stats.triangles);
        EXPECT_EQ(culled_stats.hidden_instances, again_stats.hidden_instances);
        hidden += culled_stats.hidden_triangles;
    }
    return hidden;
}

DBox3 streets(const DBox3& bounds) {
    DBox3 box = bounds;
    box.low.y = 1.0;
    box.high.y = 3.0;
    return box;
}

TEST_F(OcclusionTest, changes_no_pixel_of_a_city_and_leaves_out_what_buildings_hide) {
    const scene::SceneData world = test::make_city({.cells = 8, .subdivisions = 3});
    EXPECT_GT(expect_same_ids(world, streets(world.bounds), 16), 10'000u);
}

TEST_F(OcclusionTest, changes_no_pixel_of_things_before_behind_and_through_walls) {
    scene::SceneData world;
    world.materials.push_back(test::plain_material());
    test::Random random(12);
    scene::MeshSource wall, thing;
    test::append_box(wall, {-15, 0, -0.2f}, {15, 8, 0.2f}, 1, 0);
    test::append_box(thing, {-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}, 3, 0);
    const std::uint32_t wall_mesh = world.add_mesh(scene::prepare_mesh(std::move(wall), world.materials));
    const std::uint32_t thing_mesh = world.add_mesh(scene::prepare_mesh(std::move(thing), world.materials));
    for (std::uint32_t i = 0; i < 12; ++i) {
        const WorldPos at(random.in(-30, 30), 0.0, random.in(-30, 30));
        const Mat3 turned = test::turned_and_scaled(random.in(0.0, 2.0 * kPi), Vec3(1.0f));
        world.add_instance(wall_mesh, at, turned, i);
        // Around the wall within 2 m on both sides, and up to its edges.
        for (int k = 0; k < 60; ++k) {
            const Vec3 offset = turned * random.in_box({-16, 0, -2}, {16, 9, 2});
            const Mat3 thing_turned =
                test::turned_and_scaled(random.in(0.0, 2.0 * kPi), random.in_box(Vec3(0.2f), Vec3(3.0f)));
            world.add_instance(thing_mesh, at + WorldPos(offset), thing_turned, i);
        }
    }
    world.finish(16);
    EXPECT_GT(expect_same_ids(world, streets(world.bounds), 24), 10'000u);
}

TEST_F(OcclusionTest, changes_no_pixel_of_a_wood_of_masked_leaves) {
    const scene::SceneData world = test::make_forest({.trees = 600, .size_m = 120.0});
    expect_same_ids(world, streets(world.bounds), 12);
}

TEST_F(OcclusionTest, changes_no_pixel_of_hills_a_thousand_kilometres_from_the_origin) {
    const WorldPos origin(1e6, 0.0, -1e6);
    const scene::SceneData world = test::make_terrain({.size_m = 8000.0, .relief_m = 200.0}, {.origin = origin});
    expect_same_ids(world, world.bounds, 12);
}

TEST_F(OcclusionTest, changes_no_pixel_of_triangle_soup) {
    const scene::SceneData world = test::make_triangle_soup({.triangles = 400, .meshes = 30, .masked = true});
    expect_same_ids(world, world.bounds, 12);
}

TEST_F(OcclusionTest, hides_moving_instances_behind_walls_and_shows_those_before) {
    scene::SceneData world;
    world.materials.push_back(test::plain_material());
    scene::MeshSource wall, thing;
    test::append_quad(wall, {-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}, 0);
    test::append_box(thing, {-1, -1, -1}, {1, 1, 1}, 4, 0);
    world.add_instance(world.add_mesh(scene::prepare_mesh(std::move(wall), world.materials)), {0, 0, -10}, Mat3(1.0f),
                       0);
    world.add_instance(world.add_mesh(scene::prepare_mesh(std::move(thing), world.materials)), {0, 0, -30}, Mat3(1.0f),
                       0);
    world.finish(16);
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer->set_occlusion({.price_triangles = 0});
    std::vector<scene::Instance> dynamic(2, scene.instances[1]);
    const auto move_to = [](scene::Instance& instance, double z) {
        instance.bounds.low.z += z - instance.position.z;
        instance.bounds.high.z += z - instance.position.z;
        instance.position.z = z;
    };
    move_to(dynamic[0], -20.0);  // behind the wall
    move_to(dynamic[1], -5.0);
    const std::uint32_t ids[] = {2, 3, 0, 1};
    farfield::VisibilityBuffer buffer;
    NearStats stats;
    ASSERT_TRUE(renderer->render_ids(make_view({}, 64, 64), {.instances = ids, .dynamic = dynamic}, buffer, stats));
    EXPECT_EQ(buffer.instance[buffer.index(32, 32)], 3u);
    EXPECT_EQ(stats.hidden_instances, 2u);
}

TEST_F(OcclusionTest, pauses_where_it_saves_nothing) {
    const scene::SceneData world = test::make_terrain({.spacing_m = 4.0, .relief_m = 0.0});
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer->set_occlusion({.price_triangles = 1000});
    const PinholeView view = make_view({.position = {0, 30, 0}, .pitch = -0.3}, 64, 64);
    visibility::VisibleSet visible;
    visibility::Culler(scene).cull(view, {}, visible);
    farfield::VisibilityBuffer buffer;
    std::uint64_t first_calls = 0, second_calls = 0;
    for (std::uint64_t* calls : {&first_calls, &second_calls}) {
        NearStats stats;
        ASSERT_TRUE(renderer->render_ids(view, {.instances = visible.instances}, buffer, stats));
        ASSERT_GT(stats.triangles, 2000u);
        *calls = stats.calls;
    }
    EXPECT_GT(first_calls, second_calls) << "the first frame is drawn in two parts";
}

}  // namespace
}  // namespace ff::nearfield
