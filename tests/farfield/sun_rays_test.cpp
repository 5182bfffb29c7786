// Sun rays against Embree's, against plain ones in double, and against what must be so.

#include "engine/farfield/sun_rays.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/ray_caster.h"
#include "engine/farfield/sun_rays_reference.h"
#include "tests/support/tiles.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

using scene::SceneData;
using scene::StaticScene;

const Vec3 kAfternoon = glm::normalize(Vec3(0.45f, 0.62f, 0.64f));
const Vec3 kEvening = glm::normalize(Vec3(-0.8f, 0.05f, 0.3f));

/// What a view sees and which of it is lit.
struct Picture {
    PinholeView view;
    VisibilityBuffer visibility;
    std::vector<std::uint8_t> lit;
    CastCost cost;

    [[nodiscard]] std::uint8_t lit_at(int x, int y) const { return lit[visibility.index(x, y)]; }
};

constexpr std::uint8_t kUntouched = 77;

Picture make_picture(const StaticScene& scene, const Camera& camera, const Vec3& to_sun, int width = 160,
                     int height = 120) {
    Picture picture{make_view(camera, width, height), {}, {}, {}};
    picture.visibility.resize(width, height);
    const auto tiles = test::all_tiles(width, height);
    make_beam_caster(scene)->cast_tiles(picture.view, tiles, picture.visibility);
    picture.lit.assign(picture.visibility.depth.size(), kUntouched);
    picture.cost = SunRays(scene).cast(picture.view, picture.visibility, tiles, {}, to_sun, picture.lit.data());
    return picture;
}

/// Pixels of a picture that differ from the plain rays'.
struct Difference {
    int rays = 0, lit = 0, wrong = 0;
};
Difference compare(const StaticScene& scene, const Picture& picture, const Vec3& to_sun) {
    Difference difference;
    for (int y = 0; y < picture.view.height; ++y)
        for (int x = 0; x < picture.view.width; ++x) {
            const SunQuestion question =
                sun_question_reference(scene, picture.view, picture.visibility, {}, to_sun, x, y);
            bool sees_sun = question.kind == SunQuestion::Kind::sky;
            if (question.kind == SunQuestion::Kind::ray) {
                ++difference.rays;
                sees_sun = !is_occluded_reference(scene, 0, question.ray);
                difference.lit += sees_sun;
            }
            difference.wrong += picture.lit_at(x, y) != (sees_sun ? 255 : 0);
        }
    return difference;
}

TEST(SunRays, a_city_is_lit_as_embree_finds_it) {
    const SceneData data = test::make_city({.cells = 2, .subdivisions = 2});
    const StaticScene scene = data.view();
    const auto embree = make_embree_caster(scene);
    test::Random random(3);
    int wrong = 0, rays = 0;
    for (int i = 0; i < 6; ++i) {
        const Camera camera{.position = {random.in(-60, 60), random.in(1, 90), random.in(-60, 60)},
                            .yaw = random.in(-kPi, kPi),
                            .pitch = random.in(-0.7, 0.1)};
        const Picture picture = make_picture(scene, camera, kAfternoon);
        for (int y = 0; y < picture.view.height; ++y)
            for (int x = 0; x < picture.view.width; ++x) {
                const SunQuestion question =
                    sun_question_reference(scene, picture.view, picture.visibility, {}, kAfternoon, x, y);
                if (question.kind != SunQuestion::Kind::ray) continue;
                const Ray ray{question.ray.origin, Vec3(question.ray.direction)};
                RayHit hit;
                embree->cast_rays({&ray, 1}, {&hit, 1});
                ++rays;
                wrong += picture.lit_at(x, y) != (std::isinf(hit.t) ? 255 : 0);
            }
    }
    EXPECT_GT(rays, 20000);
    EXPECT_LE(wrong, rays / 20000);
}

/// Pictures from random cameras within a box, against plain rays.
Difference compare_views(const SceneData& data, const DBox3& cameras, const Vec3& to_sun, int views,
                         std::uint32_t seed) {
    const StaticScene scene = data.view();
    test::Random random(seed);
    Difference sum;
    for (int i = 0; i < views; ++i) {
        Camera camera = test::random_camera(random, cameras);
        camera.pitch = -0.3 + 0.3 * camera.pitch;
        const Picture picture = make_picture(scene, camera, to_sun);
        const Difference one = compare(scene, picture, to_sun);
        sum.rays += one.rays, sum.lit += one.lit, sum.wrong += one.wrong;
    }
    return sum;
}

TEST(SunRays, agree_with_plain_rays_everywhere_and_far_from_the_worlds_origin) {
    struct World {
        const char* name;
        SceneData data;
        DBox3 cameras;
    };
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 300.0, -1e6)}) {
        const test::WorldSettings settings{.origin = origin};
        const auto box = [&](double size, double low, double high) {
            return DBox3{origin + DVec3(-size, low, -size), origin + DVec3(size, high, size)};
        };
        const World worlds[] = {
            {"city", test::make_city({.cells = 2, .subdivisions = 3}, settings), box(100, 2, 70)},
            {"terrain", test::make_terrain({.size_m = 2000, .spacing_m = 10}, settings), box(600, 60, 200)},
            {"leaves", test::make_forest({.trees = 150, .size_m = 100, .masked = false}, settings), box(50, 1, 15)},
            {"masked leaves", test::make_forest({.trees = 150, .size_m = 100}, settings), box(50, 1, 15)},
            {"soup", test::make_triangle_soup({.triangles = 300}, settings), box(15, -10, 10)},
            {"masked soup", test::make_triangle_soup({.triangles = 300, .masked = true}, settings), box(15, -10, 10)},
        };
        for (const World& world : worlds)
            for (const Vec3& to_sun : {kAfternoon, kEvening, Vec3(0, 1, 0)}) {
                const Difference d = compare_views(world.data, world.cameras, to_sun, 4, 5);
                fmt::print("{:14} {:8} rays, {:8} lit, {:4} differ\n", world.name, d.rays, d.lit, d.wrong);
                EXPECT_GT(d.rays, 1000) << world.name;
                EXPECT_LE(d.wrong, 2 + d.rays / 2000) << world.name;
            }
    }
}

/// Tiles of which about a fifth of the pixels is asked for.
std::vector<TileRequest> strewn_tiles(int width, int height) {
    std::vector<TileRequest> tiles = test::all_tiles(width, height);
    test::Random random(9);
    for (TileRequest& tile : tiles)
        for (std::uint16_t& row : tile.rows) row = std::uint16_t(random.below(0x10000u) & random.below(0x10000u));
    return tiles;
}

TEST(SunRays, no_light_falls_into_closed_surfaces) {
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 50.0, 1e6)})
        for (const double bump : {0.0, 0.2}) {
            const SceneData data = test::make_closed_sphere(10.0, 40, bump, {.origin = origin});
            test::Random random(2);
            std::uint64_t rays = 0;
            for (int i = 0; i < 12; ++i) {
                Camera camera = test::random_camera(random, {origin - 3.0, origin + 3.0});
                const Vec3 to_sun = glm::normalize(random.in_box(Vec3(-1.0f), Vec3(1.0f)));
                const Picture picture = make_picture(data.view(), camera, to_sun);
                int lit = 0;
                for (int y = 0; y < picture.view.height; ++y)
                    for (int x = 0; x < picture.view.width; ++x) lit += picture.lit_at(x, y) != 0;
                rays += picture.cost.rays;
                EXPECT_EQ(lit, 0) << "view " << i << ", bump " << bump;
            }
            EXPECT_GT(rays, 50000u);
        }
}

TEST(SunRays, convex_surfaces_do_not_shadow_themselves) {
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 50.0, 1e6)}) {
        const SceneData data = test::make_closed_sphere(10.0, 60, 0.0, {.origin = origin});
        test::Random random(4);
        for (const double distance : {12.0, 100.0, 1500.0})
            for (int i = 0; i < 8; ++i) {
                const DVec3 from = glm::normalize(DVec3(random.in_box(Vec3(-1.0f), Vec3(1.0f))));
                Camera camera{.position = origin + from * distance};
                camera.yaw = std::atan2(-from.x, from.z);
                camera.pitch = -std::asin(from.y);
                camera.vertical_fov = 2.2 * std::asin(10.0 / distance);
                const Vec3 to_sun = glm::normalize(random.in_box(Vec3(-1.0f), Vec3(1.0f)));
                const Picture picture = make_picture(data.view(), camera, to_sun);
                int rays = 0, dark = 0;
                for (int y = 0; y < picture.view.height; ++y)
                    for (int x = 0; x < picture.view.width; ++x) {
                        const SunQuestion question =
                            sun_question_reference(data.view(), picture.view, picture.visibility, {}, to_sun, x, y);
                        if (question.kind != SunQuestion::Kind::ray) continue;
                        ++rays;
                        dark += picture.lit_at(x, y) == 0;
                    }
                // A normal within a rounding of the terminator may be found on either side.
                EXPECT_LE(dark, rays / 1000) << "distance " << distance << ", view " << i;
            }
    }
}

/// A flat ground of many quads, all of it twice: as two meshes that coincide.
SceneData coincident_grounds(const WorldPos& origin) {
    SceneData data;
    data.materials.push_back(test::plain_material());
    scene::MeshSource ground;
    for (int i = 0; i < 40; ++i)
        for (int j = 0; j < 40; ++j) {
            const float x = 17.3f * float(i - 20), z = 17.3f * float(j - 20), e = 17.3f;
            test::append_quad(ground, {x, 0, z}, {x, 0, z + e}, {x + e, 0, z + e}, {x + e, 0, z}, 0);
        }
    const std::uint32_t mesh = data.add_mesh(scene::prepare_mesh(ground, data.materials));
    data.add_instance(mesh, origin, Mat3(1.0f), 0);
    data.add_instance(mesh, origin, test::turned_and_scaled(kPi / 2, Vec3(1.0f)), 0);
    data.finish(16);
    return data;
}

TEST(SunRays, coincident_and_flat_surfaces_stay_lit_under_a_grazing_sun) {
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 50.0, 1e6)}) {
        const SceneData data = coincident_grounds(origin);
        for (const float height : {1.0f, 0.05f, 0.005f}) {
            const Vec3 to_sun = glm::normalize(Vec3(0.6f, height, -0.8f));
            for (const double eye : {0.3, 1.7, 60.0, 900.0}) {
                const Camera camera{
                    .position = origin + DVec3(3.0, eye, 5.0), .yaw = 0.4, .pitch = eye > 30 ? -1.2 : -0.2};
                const Picture picture = make_picture(data.view(), camera, to_sun);
                int dark = 0;
                for (int y = 0; y < picture.view.height; ++y)
                    for (int x = 0; x < picture.view.width; ++x) dark += picture.lit_at(x, y) == 0;
                EXPECT_GT(picture.cost.rays, 1000u);
                EXPECT_EQ(dark, 0) << "sun " << height << ", eye " << eye;
            }
        }
    }
}

/// A ground, and a wall on it along x = 0, 4 m high.
SceneData wall_on_ground(const WorldPos& origin) {
    SceneData data;
    data.materials.push_back(test::plain_material());
    scene::MeshSource ground, wall;
    test::append_quad(ground, {-50, 0, -50}, {-50, 0, 50}, {50, 0, 50}, {50, 0, -50}, 0);
    test::append_box(wall, {-0.1f, 0, -20}, {0.1f, 4, 20}, 3, 0);
    const std::uint32_t ground_mesh = data.add_mesh(scene::prepare_mesh(ground, data.materials));
    const std::uint32_t wall_mesh = data.add_mesh(scene::prepare_mesh(wall, data.materials));
    data.add_instance(ground_mesh, origin, Mat3(1.0f), 0);
    data.add_instance(wall_mesh, origin, Mat3(1.0f), 0);
    data.finish(16);
    return data;
}

TEST(SunRays, walls_shadow_the_ground_up_to_their_foot) {
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 50.0, 1e6)}) {
        const SceneData data = wall_on_ground(origin);
        const Vec3 to_sun = glm::normalize(Vec3(1, 1, 0));  // the shadow is as long as the wall is high
        std::vector<SunPoint> points;
        std::vector<std::uint8_t> expected;
        for (const float z : {-15.0f, 0.0f, 7.7f})
            for (const float x : {0.001f, 0.01f, 0.3f, 3.9f, 3.99f, 4.01f, 4.3f}) {
                for (const float side : {-1.0f, 1.0f}) {
                    points.push_back(
                        {.position = {side * (0.1f + x), 0.0f, z}, .normal = {0, 1, 0}, .offset_m = 1e-4f});
                    // The upper edge that the sun is seen over last stands above x = -0.1.
                    expected.push_back(side > 0.0f || x > 4.0f ? 255 : 0);
                }
            }
        std::vector<std::uint8_t> lit(points.size(), kUntouched);
        const CastCost cost = SunRays(data.view()).cast_points(origin, points, {}, to_sun, lit.data());
        EXPECT_EQ(cost.rays, points.size());
        for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(lit[i], expected[i]) << points[i].position.x;
    }
}

TEST(SunRays, moving_instances_cast_and_take_shadows) {
    const WorldPos origin(2000.0, 0.0, 100.0);
    const SceneData data = wall_on_ground(origin);
    const StaticScene whole = data.view();
    // The same with the wall as a moving instance: its name stays what it was.
    StaticScene ground = whole;
    ground.instances = whole.instances.first(1);
    std::vector<scene::BvhNode> nodes;
    scene::build_instance_bvh(ground.instances, ground.origin, nodes);
    ground.instance_nodes = nodes;
    const Camera camera{.position = origin + DVec3(-7, 3, 9), .yaw = 0.5, .pitch = -0.3};
    const Vec3 to_sun = glm::normalize(Vec3(1.0f, 0.8f, 0.1f));
    const Picture expected = make_picture(whole, camera, to_sun);
    std::vector<std::uint8_t> lit(expected.lit.size(), kUntouched);
    const auto tiles = test::all_tiles(expected.view.width, expected.view.height);
    SunRays rays(ground);
    const CastCost cost =
        rays.cast(expected.view, expected.visibility, tiles, whole.instances.subspan(1), to_sun, lit.data());
    EXPECT_EQ(cost.rays, expected.cost.rays);
    EXPECT_EQ(lit, expected.lit);
    const auto dark_pixels = [](const std::vector<std::uint8_t>& all) { return std::count(all.begin(), all.end(), 0); };
    const Picture without = make_picture(ground, camera, to_sun);
    EXPECT_GT(dark_pixels(lit), dark_pixels(without.lit) + 500);
}

TEST(SunRays, the_number_of_workers_changes_nothing) {
    const SceneData data = test::make_forest({.trees = 300, .size_m = 150});
    const Camera camera{.position = {3, 4, 5}, .yaw = 0.7, .pitch = -0.1};
    std::vector<Picture> pictures;
    for (const int workers : {1, 2, 4, 1}) {
        const WorkerLimit limit(workers);
        pictures.push_back(make_picture(data.view(), camera, kAfternoon, 320, 240));
        EXPECT_EQ(pictures.back().lit, pictures.front().lit) << workers;
        EXPECT_EQ(pictures.back().cost.rays, pictures.front().cost.rays);
        EXPECT_EQ(pictures.back().cost.nodes, pictures.front().cost.nodes);
        EXPECT_EQ(pictures.back().cost.triangles, pictures.front().cost.triangles);
    }
}

TEST(SunRays, every_instruction_set_sees_the_same_sun) {
    const SceneData forest = test::make_forest({.trees = 150, .size_m = 100});
    const SceneData sphere = test::make_closed_sphere(10.0, 40, 0.2);
    const Camera camera{.position = {3, 4, 5}, .yaw = 0.7, .pitch = -0.1};
    const Picture best = make_picture(forest.view(), camera, kAfternoon);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().DeInit();
        std::vector<std::uint8_t> lit(best.lit.size(), kUntouched);
        SunRays(forest.view())
            .cast(best.view, best.visibility, test::all_tiles(best.view.width, best.view.height), {}, kAfternoon,
                  lit.data());
        int different = 0;
        for (std::size_t i = 0; i < lit.size(); ++i) different += lit[i] != best.lit[i];
        EXPECT_LT(different, 5) << hwy::TargetName(target);  // rounding at edges and at texels' borders
        for (const std::uint8_t inside : make_picture(sphere.view(), Camera{}, kAfternoon, 160, 112).lit)
            ASSERT_EQ(inside, 0) << hwy::TargetName(target);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
}

TEST(SunRays, only_what_was_asked_for_is_written) {
    const SceneData data = test::make_city({.cells = 2, .subdivisions = 2});
    const Camera camera{.position = {40, 20, 0}, .pitch = -0.2};
    const int width = 150, height = 100;  // no multiples of tiles
    const Picture whole = make_picture(data.view(), camera, kAfternoon, width, height);
    std::vector<std::uint8_t> lit(whole.lit.size(), kUntouched);
    const auto tiles = strewn_tiles(width, height);
    SunRays(data.view()).cast(whole.view, whole.visibility, tiles, {}, kAfternoon, lit.data());
    int different = 0;
    for (const TileRequest& tile : tiles)
        for (int i = 0; i < kTileSize * kTileSize; ++i) {
            const int x = tile.x + i % kTileSize, y = tile.y + i / kTileSize;
            const std::size_t at = whole.visibility.index(x, y);
            const bool is_asked = ((tile.rows[i / kTileSize] >> i % kTileSize) & 1) != 0 && x < width && y < height;
            if (is_asked)
                different += lit[at] != whole.lit[at];
            else
                EXPECT_EQ(lit[at], kUntouched) << x << ", " << y;
        }
    EXPECT_LE(different, 1);
}

TEST(SunRays, sky_and_empty_worlds_are_lit_and_points_may_be_anything) {
    const SceneData empty = test::make_empty_world();
    const Picture picture = make_picture(empty.view(), Camera{}, kAfternoon, 32, 32);
    for (const std::uint8_t lit : picture.lit) EXPECT_EQ(lit, 255);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const SceneData data = wall_on_ground(WorldPos(0.0));
    const SunPoint points[] = {{.position = {nan, 0, 0}, .normal = kAfternoon},
                               {.position = {0, 500, 0}},
                               {.position = {0, 500, 0}, .normal = -kAfternoon},
                               {.position = {1e7f, 3e7f, 0}, .normal = kAfternoon},
                               {.position = {5, -1, 5}, .normal = {0, 1, 0}}};
    std::uint8_t lit[5];
    SunRays(data.view()).cast_points(WorldPos(0.0), points, {}, kAfternoon, lit);
    EXPECT_EQ(lit[0], 255);
    EXPECT_EQ(lit[1], 255);
    EXPECT_EQ(lit[2], 0);
    EXPECT_EQ(lit[3], 255);
    EXPECT_EQ(lit[4], 0) << "below the ground";
}

}  // namespace
}  // namespace ff::farfield
