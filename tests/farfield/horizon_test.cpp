// The horizon against its plain reference, and against rays cast at every triangle: what is called sky is sky.
#include "engine/farfield/horizon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/farfield/horizon_azimuth.h"
#include "tests/farfield/horizon_worlds.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

using test::make_valley_grid;
using test::meets_bars;
using test::OwnedHeightGrid;

struct Random {
    explicit Random(int seed) : engine(std::uint32_t(seed)) {}
    double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
    std::mt19937 engine;
};

std::vector<float> traced(const OwnedHeightGrid& world, const WorldPos& eye, const HorizonSettings& settings) {
    HorizonMap map(settings);
    map.update(world.grid, eye, {0, settings.columns});
    return {map.tangents().begin(), map.tangents().end()};
}

TEST(Horizon, is_never_below_the_plain_reference_and_little_above_it) {
    for (int seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const auto world = make_valley_grid(64u << (seed % 3), 30.0, std::uint32_t(seed));
        const double reach = (seed % 4 == 0 ? 1.5 : 0.5) * world.grid.size * 30.0;
        const WorldPos eye(random.between(-reach, reach), random.between(-50, seed % 5 == 0 ? 1500 : 200),
                           random.between(-reach, reach));
        const HorizonSettings settings{.columns = seed % 2 ? 1280 : 320, .near_distance_m = seed % 3 == 1 ? 100.0f : 0};
        const std::vector<float> fast = traced(world, eye, settings);
        std::vector<double> reference(fast.size());
        trace_horizon_reference(world.grid, eye, settings.near_distance_m, reference);
        // A wedge is a hair wider than its column, so a few columns also see what stands beside them.
        int higher = 0;
        for (std::size_t c = 0; c < fast.size(); ++c) {
            ASSERT_GE(double(fast[c]), reference[c]) << "column " << c;
            higher += double(fast[c]) > reference[c] + 0.02 * std::abs(reference[c]) + 0.01 ? 1 : 0;
        }
        EXPECT_LE(higher, int(fast.size() / 100));
    }
}

TEST(Horizon, subsampled_is_never_below_the_full_one) {
    for (int seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const auto world = make_valley_grid(128, 30.0, std::uint32_t(seed));
        const WorldPos eye(random.between(-1900, 1900), random.between(50, 400), random.between(-1900, 1900));
        const std::vector<float> full = traced(world, eye, {});
        for (const int subsample : {2, 4}) {
            const std::vector<float> coarse = traced(world, eye, {.subsample = subsample});
            for (std::size_t c = 0; c < full.size(); ++c)
                ASSERT_GE(coarse[c] + 1e-5f * std::abs(coarse[c]) + 1e-5f, full[c]) << "column " << c;
        }
    }
}

TEST(Horizon, a_guess_from_the_last_frame_changes_time_but_no_bit) {
    const auto world = make_valley_grid(256, 30.0, 3);
    HorizonMap walking;
    for (int frame = 0; frame < 30; ++frame) {
        const WorldPos eye(600.0 + 3.0 * frame, 120.0, 40.0 * std::sin(0.1 * frame));
        walking.update(world.grid, eye, {0, 1280});
        const std::vector<float> fresh = traced(world, eye, {});
        ASSERT_TRUE(std::equal(fresh.begin(), fresh.end(), walking.tangents().begin())) << "frame " << frame;
    }
}

TEST(Horizon, a_spire_thinner_than_a_column_is_not_lost) {
    OwnedHeightGrid world(1024, -5120.0, -5120.0, 10.0, 0.0);
    for (std::uint32_t z = 0; z < 1024; ++z)
        for (std::uint32_t x = 0; x < 1024; ++x) world.at(x, z) = 0.0f;
    world.at(900, 300) = 200.0f;
    world.make_mips();
    const std::vector<float> tangents = traced(world, {3.0, 2.0, 4.0}, {.columns = 64});
    EXPECT_GT(*std::max_element(tangents.begin(), tangents.end()), 0.04f);
    EXPECT_LE(std::count_if(tangents.begin(), tangents.end(), [](float t) { return t > 0.01f; }), 2);
}

TEST(Horizon, nothing_is_traced_while_only_the_direction_changes_within_what_is_known) {
    const auto world = make_valley_grid(256, 30.0, 1);
    Camera camera;
    camera.position = {1500.0, 150.0, 0.0};
    HorizonMap map;
    const auto first = map.update(world.grid, make_view(camera, 320, 240));
    EXPECT_GT(first.columns, 200u);
    EXPECT_LT(first.columns, 500u);
    camera.pitch = 0.05;
    EXPECT_EQ(map.update(world.grid, make_view(camera, 320, 240)).columns, 0u);
    camera.yaw = 0.2;
    const auto turned = map.update(world.grid, make_view(camera, 320, 240));
    EXPECT_GT(turned.columns, 0u);
    EXPECT_LT(turned.columns, 60u);
    for (camera.yaw = 0.2; camera.yaw < 7.0; camera.yaw += 0.3) map.update(world.grid, make_view(camera, 320, 240));
    EXPECT_EQ(map.update(world.grid, camera.position, {0, 1280}).columns, 0u);
    const std::vector<float> fresh = traced(world, camera.position, {});
    EXPECT_TRUE(std::equal(fresh.begin(), fresh.end(), map.tangents().begin()));
    camera.position.x += 0.001;
    EXPECT_GT(map.update(world.grid, make_view(camera, 320, 240)).columns, 200u);
}

TEST(Horizon, serves_a_walk_for_some_frames_and_is_exact_again_once_it_ends) {
    const auto world = make_valley_grid(256, 30.0, 2);
    HorizonMap ahead({.frames_ahead = 8});
    Camera camera;
    camera.position = {1500.0, 150.0, 0.0};
    int traced_frames = 0;
    for (int frame = 0; frame < 40; ++frame) {
        camera.position.x += 0.15;
        const PinholeView view = make_view(camera, 320, 240);
        traced_frames += ahead.update(world.grid, view).columns > 0 ? 1 : 0;
        HorizonMap fresh;
        fresh.update(world.grid, view);
        for (std::size_t c = 0; c < fresh.tangents().size(); ++c) {
            if (!std::isfinite(fresh.tangents()[c])) continue;
            ASSERT_GE(ahead.tangents()[c], fresh.tangents()[c] - 1e-5f);
            ASSERT_LT(ahead.tangents()[c], fresh.tangents()[c] + 0.1f);
        }
    }
    EXPECT_LE(traced_frames, 7);
    EXPECT_GT(ahead.update(world.grid, make_view(camera, 320, 240)).columns, 0u);
    EXPECT_EQ(ahead.update(world.grid, make_view(camera, 320, 240)).columns, 0u);
    HorizonMap fresh;
    fresh.update(world.grid, make_view(camera, 320, 240));
    EXPECT_TRUE(std::equal(fresh.tangents().begin(), fresh.tangents().end(), ahead.tangents().begin()));
}

TEST(Horizon, calls_nothing_sky_where_it_knows_nothing) {
    PixelMask sky;
    const PinholeView view = make_view({}, 100, 70);
    HorizonMap untraced;
    EXPECT_EQ(find_sky_pixels(view, untraced, sky), 0u);
    scene::HeightGrid none;
    HorizonMap map;
    map.update(none, view);
    EXPECT_EQ(find_sky_pixels(view, map, sky), 0u);
    const auto world = make_valley_grid(64, 30.0, 1);
    for (const double bad : {std::nan(""), 1e30, std::numeric_limits<double>::infinity()}) {
        map.update(world.grid, WorldPos(bad, 10.0, 0.0), {0, 1280});
        EXPECT_EQ(find_sky_pixels(view, map, sky), 0u);
        map.update(world.grid, WorldPos(0.0, bad, 0.0), {0, 1280});
        if (!(bad > 0.0)) {
            EXPECT_EQ(find_sky_pixels(view, map, sky), 0u);
        }
    }
}

// ---- against rays ----------------------------------------------------------------------------------------------

TEST(Horizon, no_pixel_that_a_ray_hits_is_called_sky_for_any_pitch_roll_and_eye) {
    std::uint64_t true_sky = 0, found_sky = 0;
    for (int seed = 0; seed < 120; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const double square = random.between(1.0, 100.0);
        OwnedHeightGrid world(16, random.between(-5e5, 5e5), random.between(-5e5, 5e5), square,
                              random.between(-100, 100));
        const double tallest = square * random.between(0.2, 4.0);
        for (std::uint32_t z = 0; z < 16; ++z)
            for (std::uint32_t x = 0; x < 16; ++x)
                if (random.between(0, 1) < 0.5) world.at(x, z) = float(tallest * std::pow(random.between(0, 1), 3.0));
        world.make_mips();

        Camera camera;
        const double margin = seed % 3 == 0 ? 12.0 : 0.0;
        camera.position = {world.grid.low_x + square * random.between(-margin, 16.0 + margin),
                           world.grid.base_y + tallest * random.between(seed % 2 ? 0.0 : -0.5, seed % 7 ? 0.8 : 6.0),
                           world.grid.low_z + square * random.between(-margin, 16.0 + margin)};
        camera.yaw = random.between(-kPi, kPi);
        camera.pitch = seed % 9 == 0 ? kPi / 2 : seed % 10 == 0 ? -kPi / 2 : random.between(-kPi / 2, kPi / 2);
        camera.roll = random.between(-kPi, kPi);
        camera.vertical_fov = random.between(0.2, 2.4);
        const HorizonSettings settings{.columns = seed % 4 ? 1280 : 128,
                                       .near_distance_m = seed % 5 == 0 ? float(2.0 * square) : 0.0f,
                                       .subsample = seed % 8 == 1   ? 2
                                                    : seed % 8 == 2 ? 4
                                                                    : 1,
                                       .frames_ahead = seed % 2 ? 8 : 0};
        const PinholeView view = make_view(camera, 75, 50);
        HorizonMap map(settings);
        test::walk_to(world.grid, view, 0.02 * square, std::uint32_t(seed), map);
        PixelMask sky;
        const std::uint64_t count = find_sky_pixels(view, map, sky);
        EXPECT_EQ(count, sky.count());
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const bool hit =
                    meets_bars(world, camera.position, DVec3(view.direction(x, y)), double(settings.near_distance_m));
                ASSERT_FALSE(hit && sky.test(x, y)) << "pixel " << x << ", " << y;
                // In open scenes nearly all of the sky is found; bars beside the eye cost more, as do coarse wedges.
                if (settings.subsample == 1 && settings.columns == 1280) {
                    true_sky += hit ? 0 : 1;
                    found_sky += sky.test(x, y) ? 1 : 0;
                }
            }
    }
    EXPECT_GT(double(found_sky), 0.8 * double(true_sky));
}

/// Every triangle of a scene in world coordinates relative to the eye, nearest hit not needed.
class AllTriangles {
  public:
    AllTriangles(const scene::StaticScene& scene, const WorldPos& eye) {
        for (const scene::Instance& instance : scene.instances) {
            const scene::Mesh& mesh = scene.meshes[instance.mesh];
            for (std::uint32_t t = mesh.first_triangle; t < mesh.first_triangle + mesh.triangle_count; ++t)
                for (std::size_t k = 0; k < 3; ++k)
                    corners_.push_back(DMat3(instance.world_from_mesh) *
                                           DVec3(scene.positions[mesh.first_vertex + scene.indices[t * 3 + k]]) +
                                       (instance.position - eye));
        }
    }
    [[nodiscard]] bool meets(const DVec3& direction) const {
        for (std::size_t i = 0; i < corners_.size(); i += 3) {
            const DVec3 &a = corners_[i], &b = corners_[i + 1], &c = corners_[i + 2];
            const double u = glm::dot(direction, glm::cross(a, b)), v = glm::dot(direction, glm::cross(b, c)),
                         w = glm::dot(direction, glm::cross(c, a));
            if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) || u + v + w == 0.0) continue;
            const DVec3 normal = glm::cross(b - a, c - a);
            if (glm::dot(normal, a) / glm::dot(normal, direction) > 0.0) return true;
        }
        return false;
    }

  private:
    std::vector<DVec3> corners_;
};

/// Rays against every triangle of a scene whose grid squares are as large as its houses. @return share of the true sky
/// that was found.
double check_scene(const scene::StaticScene& scene, int seeds, double lowest_m, double highest_m, double reach_m) {
    std::uint64_t true_sky = 0, found_sky = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Camera camera;
        camera.position =
            scene.origin + DVec3(random.between(-reach_m, reach_m), 0.0, random.between(-reach_m, reach_m));
        camera.position.y = random.between(lowest_m, highest_m);
        camera.yaw = random.between(-kPi, kPi);
        camera.pitch = random.between(-0.3, 1.2);
        camera.roll = random.between(-1.0, 1.0);
        const PinholeView view = make_view(camera, 48, 36);
        HorizonMap map({.columns = seed % 5 == 4 ? 256 : 1280,
                        .subsample = seed % 7 == 6 ? 2 : 1,
                        .frames_ahead = seed % 2 ? 8 : 0});
        test::walk_to(scene, view, seed % 3 ? 0.1 : 0.8, std::uint32_t(seed), map);
        PixelMask sky;
        find_sky_pixels(view, map, sky);
        const AllTriangles triangles(scene, camera.position);
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const bool called_sky = sky.test(x, y), hit = triangles.meets(DVec3(view.direction(x, y)));
                if (hit && called_sky) {
                    ADD_FAILURE() << "pixel " << x << ", " << y;
                    return 0.0;
                }
                true_sky += hit ? 0 : 1;
                found_sky += called_sky ? 1 : 0;
            }
    }
    return double(found_sky) / double(std::max<std::uint64_t>(1, true_sky));
}

TEST(Horizon, keeps_the_sky_of_a_street_whose_grid_squares_hold_houses) {
    const scene::SceneData city =
        test::make_city({.cells = 3, .subdivisions = 2}, {.origin = {3e5, 12.0, -2e5}, .height_grid_size = 16});
    EXPECT_GT(check_scene(city.view(), 30, city.view().bounds.low.y + 1.0, city.view().bounds.low.y + 3.0, 400.0), 0.7);
}

TEST(Horizon, keeps_the_sky_of_hills_and_of_a_wood) {
    const scene::SceneData hills = test::make_terrain({.spacing_m = 60.0}, {.height_grid_size = 64});
    EXPECT_GT(check_scene(hills.view(), 20, 90.0, 200.0, 900.0), 0.9);
    const scene::SceneData wood = test::make_forest({.trees = 60, .leaves = 20}, {.height_grid_size = 16});
    check_scene(wood.view(), 15, 0.5, 30.0, 120.0);
    const scene::SceneData soup = test::make_triangle_soup({.triangles = 300, .edge_m = 8.0}, {.height_grid_size = 16});
    check_scene(soup.view(), 40, -12.0, 12.0, 14.0);
}

TEST(Horizon, columns_of_a_view_hold_every_pixel_of_it) {
    for (int seed = 0; seed < 300; ++seed) {
        Random random(seed);
        Camera camera;
        camera.yaw = random.between(-kPi, kPi);
        camera.pitch = random.between(-kPi / 2, kPi / 2);
        camera.roll = random.between(-kPi, kPi);
        camera.vertical_fov = random.between(0.1, 2.6);
        const PinholeView view = make_view(camera, 40, 30);
        const ColumnRange range = columns_of_view(view, 1280);
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const Vec3 direction = view.direction(x, y);
                const int column = int(azimuth_turn(direction.x, direction.z) * 1280.0f) % 1280;
                ASSERT_LT((column - range.first + 1280) % 1280, range.count) << "seed " << seed;
            }
    }
}

}  // namespace
}  // namespace ff::farfield
