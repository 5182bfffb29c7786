// What a mirror shows, by tile beams, against single rays that start on the mirror.

#include "engine/farfield/mirror_caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/support/tiles.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

constexpr int kWidth = 96, kHeight = 64;

MirrorPlane random_plane(test::Random& random, const WorldPos& eye, const DBox3& box) {
    const Vec3 n = glm::normalize(random.in_box(Vec3(-1.0f), Vec3(1.0f)) + Vec3(0.0f, 0.3f, 0.0f));
    const DVec3 through = (box.low + box.high) * 0.5;
    const double height = glm::dot(DVec3(n), eye - through);
    return height > 0.0 ? MirrorPlane{n, height} : MirrorPlane{-n, -height};
}

TEST(mirror_caster, shows_what_rays_from_the_mirror_meet) {
    int hits = 0, compared = 0, differ = 0;
    for (std::uint32_t seed = 0; seed < 80; ++seed) {
        const scene::SceneData world = seed % 2 == 0 ? test::make_triangle_soup({.triangles = 150}, {.seed = seed + 1})
                                                     : test::make_city({.cells = 2}, {.seed = seed + 1});
        const scene::StaticScene scene = world.view();
        test::Random random(seed);
        const PinholeView view = make_view(test::random_camera(random, scene.bounds), kWidth, kHeight);
        const MirrorPlane plane = random_plane(random, view.position, scene.bounds);
        if (plane.height_m < 0.1) continue;
        const int step = 1 + int(seed % 3);
        const PinholeView mirrored = mirrored_view(view, plane, step);
        EXPECT_EQ(mirrored.width, (kWidth + step - 1) / step);
        const DepthPlane before = mirror_before(mirrored, plane, 0.0);
        VisibilityBuffer visibility;
        visibility.resize(mirrored.width, mirrored.height);
        const std::vector<TileRequest> tiles = test::all_tiles(mirrored.width, mirrored.height);
        const MirrorRequest request{mirrored, before, tiles};
        MirrorCaster(scene).cast({&request, 1}, visibility);

        const auto caster = make_beam_caster(scene);
        for (int y = 0; y < mirrored.height; ++y)
            for (int x = 0; x < mirrored.width; ++x) {
                const std::size_t at = visibility.index(x, y);
                const DVec3 direction(mirrored.direction(x, y));
                const double slope = glm::dot(direction, DVec3(plane.normal));
                if (std::abs(slope) < 1e-3) continue;
                ++compared;
                if (slope < 0.0) {
                    differ += visibility.instance[at] != kSkyInstance;
                    continue;
                }
                const double on_mirror = plane.height_m / slope;
                const Ray ray{mirrored.position + on_mirror * direction, Vec3(direction)};
                RayHit hit;
                caster->cast_rays({&ray, 1}, {&hit, 1});
                hits += hit.instance != kSkyInstance;
                const bool is_same = hit.instance == visibility.instance[at] && hit.triangle == visibility.triangle[at];
                const double depth = on_mirror + double(hit.t);
                differ += !is_same && !(std::abs(depth - double(visibility.depth[at])) < 1e-3 * depth);
            }
    }
    EXPECT_GT(hits, 1000);
    // Single rays have no footprint and other rounding: edges differ.
    EXPECT_LT(differ, compared / 200);
}

TEST(mirror_caster, the_image_of_a_point_lies_on_the_mirror_that_shows_it) {
    const PinholeView view = make_view({.position = {3.0, 2.0, 5.0}, .yaw = 0.4, .pitch = -0.3}, kWidth, kHeight);
    const MirrorPlane water{{0.0f, 1.0f, 0.0f}, 2.0};
    const PinholeView mirrored = mirrored_view(view, water, 1);
    EXPECT_NEAR(mirrored.position.y, -2.0, 1e-12);
    for (const int x : {0, 40, kWidth - 1}) {
        const Vec3 down = view.direction(x, kHeight - 1), up = mirrored.direction(x, kHeight - 1);
        EXPECT_NEAR(down.x, up.x, 1e-6f);
        EXPECT_NEAR(down.y, -up.y, 1e-6f);
        EXPECT_NEAR(down.z, up.z, 1e-6f);
    }
}

}  // namespace
}  // namespace ff::farfield
