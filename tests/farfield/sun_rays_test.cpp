// Sun rays against Embree's, against plain ones in double, and against what must be so.

#include "engine/farfield/sun_rays.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
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

}  // namespace
}  // namespace ff::farfield
