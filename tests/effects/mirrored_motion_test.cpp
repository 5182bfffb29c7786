// Where mirrors may show what moves, against rays that are mirrored one by one.

#include "engine/effects/mirrored_motion.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <optional>
#include <random>

#include "tests/support/worlds.h"

namespace ff::effects {
namespace {

using farfield::kTileSize;
using farfield::MovingSphere;

constexpr int kWidth = 320, kHeight = 240;

struct Ray {
    WorldPos from{0.0};
    DVec3 way{0.0};  ///< unit
};

/// A pixel's ray from where it meets the plane of the scene's triangle on; nullopt where it does not.
std::optional<Ray> mirrored(const PinholeView& view, int x, int y, const scene::StaticScene& scene) {
    const scene::Instance& instance = scene.instances[0];
    const auto corner = [&](std::size_t k) {
        return DMat3(instance.world_from_mesh) * DVec3(scene.positions[scene.indices[k]]) + instance.position;
    };
    const DVec3 normal = glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
    const DVec3 ray = glm::normalize(DVec3(view.direction(x, y)));
    const double toward = glm::dot(ray, normal);
    const double t = glm::dot(corner(0) - view.position, normal) / toward;
    if (!(t > 0.0)) return std::nullopt;
    return Ray{view.position + t * ray, ray - 2.0 * toward * normal};
}

bool meets(const std::optional<Ray>& ray, const MovingSphere& sphere) {
    if (!ray) return false;
    const DVec3 to = sphere.center - ray->from;
    const double along = glm::dot(to, ray->way);
    return along > 0.0 && glm::length(to - along * ray->way) < sphere.radius;
}

TEST(mirrored_motion, no_pixel_that_shows_what_moves_is_missed) {
    std::mt19937 random(7);
    const auto between = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    const auto anywhere = [&](double reach) {
        return DVec3(between(-reach, reach), between(-reach, reach), between(-reach, reach));
    };
    int shown = 0, cleared = 0;
    for (int round = 0; round < 1500; ++round) {
        const scene::SceneData data =
            test::make_single_triangle(Vec3(anywhere(30)), Vec3(anywhere(30)), Vec3(anywhere(30)));
        const scene::StaticScene scene = data.view();
        const Camera camera{.position = anywhere(20), .yaw = between(-3, 3), .pitch = between(-1.4, 1.4)};
        const PinholeView view = make_view(camera, kWidth, kHeight);
        MovingSphere sphere{.center = anywhere(60), .radius = between(0.1, 10), .box = {}};
        const int x0 = int(between(0, kWidth / kTileSize)) * kTileSize;
        const int y0 = int(between(0, kHeight / kTileSize)) * kTileSize;
        // Every other one is just met, or just missed, by some pixel of the tile.
        if (const auto ray = mirrored(view, x0 + 5, y0 + 9, scene); ray && round % 2 == 0)
            sphere.center = ray->from + between(0, 60) * ray->way + glm::normalize(anywhere(1)) * sphere.radius * 1.02;
        MirroredMotion motion(view, std::span(&sphere, 1));
        motion.begin_tile(x0, y0);
        bool any = false;
        for (int y = y0; y < y0 + kTileSize; ++y)
            for (int x = x0; x < x0 + kTileSize; ++x) any |= meets(mirrored(view, x, y, scene), sphere);
        const auto plane = mirror_plane(scene, scene.instances[0], 0, view.position);
        const bool claimed = !plane || motion.shows(*plane);
        EXPECT_TRUE(claimed || !any) << "round " << round;
        shown += any;
        cleared += !claimed;
    }
    EXPECT_GT(shown, 40);
    EXPECT_GT(cleared, 550) << "it has to rule out most";
}

TEST(mirrored_motion, what_is_smaller_than_a_pixel_is_left_out) {
    const PinholeView view = make_view({.position = {0, 0, 0}}, kWidth, kHeight);
    const MovingSphere spheres[] = {{.center = {0, 0, -50}, .radius = 1.0, .box = {}},
                                    {.center = {0, 0, -5000}, .radius = 1.0, .box = {}},
                                    {.center = {0, 0, 0.5}, .radius = 1.0, .box = {}}};
    std::vector<MovingSphere> kept;
    find_mirrored(view, spheres, kept);
    ASSERT_EQ(kept.size(), 2u);
    EXPECT_EQ(kept[0].center.z, -50.0);
    EXPECT_EQ(kept[1].center.z, 0.5);
}

}  // namespace
}  // namespace ff::effects
