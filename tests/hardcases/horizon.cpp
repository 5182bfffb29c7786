// What the horizon calls sky is sky, wherever the eye stands and however it looks.

#include "engine/farfield/horizon.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/farfield/horizon_worlds.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

using farfield::HorizonMap;
using farfield::HorizonSettings;
using farfield::PixelMask;

constexpr std::uint32_t kSquares = 16;
constexpr int kWidth = 64, kHeight = 48;

/// Bars of random heights with gaps, sometimes only a few spires much thinner than a column.
test::OwnedHeightGrid make_bars(test::Random& random, double& tallest) {
    const bool spires = random.below(4) == 0;
    const double square = spires ? random.in(0.05, 1.0) : random.in(1.0, 100.0);
    test::OwnedHeightGrid world(kSquares, random.in(-5e5, 5e5), random.in(-5e5, 5e5), square, random.in(-100.0, 100.0));
    tallest = square * random.in(0.2, 4.0) * (spires ? 20.0 : 1.0);
    for (std::uint32_t z = 0; z < kSquares; ++z)
        for (std::uint32_t x = 0; x < kSquares; ++x) {
            const double share = random.unit();
            if (random.unit() < (spires ? 0.03 : 0.5))
                world.at(x, z) = float(tallest * share * share * share);
            else if (spires)
                world.at(x, z) = 0.0f;
        }
    world.make_mips();
    return world;
}

enum class Eye { ordinary, above_all, below_ground, on_node, on_edge, beside_tower, far_outside, count };

WorldPos place_eye(test::Random& random, const scene::HeightGrid& grid, double tallest, Eye eye) {
    const auto on_grid = [&](double squares_x, double squares_z, double height) {
        return WorldPos(grid.low_x + grid.square_m * squares_x, grid.base_y + height,
                        grid.low_z + grid.square_m * squares_z);
    };
    const double x = random.in(0.0, kSquares), z = random.in(0.0, kSquares), height = tallest * random.in(0.0, 0.8);
    switch (eye) {
        case Eye::above_all:
            return on_grid(x, z, tallest * random.in(1.0, 8.0));
        case Eye::below_ground:
            return on_grid(x, z, -tallest * random.unit());
        case Eye::on_node:
            return on_grid(std::floor(x), std::floor(z), height);
        case Eye::on_edge:
            return on_grid(std::floor(x), z, height);
        case Eye::beside_tower: {
            // A hair outside of a square, and above what stands in the neighbour.
            const double hair = std::pow(10.0, random.in(-9.0, -3.0));
            return on_grid(std::floor(x) + (random.below(2) == 0 ? hair : -hair), z, height);
        }
        case Eye::far_outside:
            return on_grid(random.in(-60.0, 80.0), random.in(-60.0, 80.0), height);
        default:
            return on_grid(x, z, height);
    }
}

/// Level, straight up and down, around north and south where azimuths begin anew, wide and narrow.
void turn_camera(test::Random& random, Camera& camera) {
    constexpr std::array<double, 5> kHairs{0.0, 1e-12, -1e-12, 1e-6, -1e-6};
    const auto hair = [&] { return kHairs[random.below(kHairs.size())]; };
    camera.yaw = random.below(3) == 0 ? 0.5 * kPi * (double(random.below(5)) - 2.0) + hair() : random.in(-kPi, kPi);
    switch (random.below(4)) {
        case 0:
            camera.pitch = (random.below(2) == 0 ? 0.5 : -0.5) * kPi + hair();
            break;
        case 1:
            camera.pitch = hair();
            break;
        default:
            camera.pitch = random.in(-0.5 * kPi, 0.5 * kPi);
    }
    camera.roll = random.below(3) == 0 ? 0.0 : random.in(-kPi, kPi);
    camera.vertical_fov = radians_of(random.below(2) == 0 ? random.in(5.0, 150.0) : random.below(2) == 0 ? 5.0 : 150.0);
}

HorizonSettings random_settings(test::Random& random, double square_m) {
    constexpr std::array<int, 3> kColumns{64, 320, 1280};
    return {.columns = kColumns[random.below(3)],
            .near_distance_m = random.below(4) == 0 ? float(2.0 * square_m) : 0.0f,
            .subsample = 1 << random.below(3),
            .frames_ahead = random.below(2) == 0 ? 8 : 0};
}

}  // namespace

void horizon_over_bars(Trial& trial) {
    PixelMask sky, walked_sky, easy_sky;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        double tallest = 0.0;
        const test::OwnedHeightGrid world = make_bars(random, tallest);
        Camera camera, easy_camera;
        camera.position = place_eye(random, world.grid, tallest, Eye(random.below(std::uint32_t(Eye::count))));
        turn_camera(random, camera);
        easy_camera.position = place_eye(random, world.grid, tallest, Eye::ordinary);
        easy_camera.yaw = random.in(-kPi, kPi);
        easy_camera.vertical_fov = camera.vertical_fov;
        const HorizonSettings settings = random_settings(random, world.grid.square_m);
        const PinholeView view = make_view(camera, kWidth, kHeight), easy = make_view(easy_camera, kWidth, kHeight);
        HorizonMap map(settings), easy_map(settings);
        trial.time_hard([&] {
            map.update(world.grid, view);
            find_sky_pixels(view, map, sky);
        });
        trial.time_easy([&] {
            easy_map.update(world.grid, easy);
            find_sky_pixels(easy, easy_map, easy_sky);
        });
        HorizonMap walked(settings);
        test::walk_to(world.grid, view, world.grid.square_m * std::pow(10.0, random.in(-4.0, -1.0)),
                      random.below(1u << 20), walked);
        find_sky_pixels(view, walked, walked_sky);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const bool is_wrong = (sky.test(x, y) || walked_sky.test(x, y)) &&
                                      test::meets_bars(world, view.position, DVec3(view.direction(x, y)),
                                                       double(settings.near_distance_m));
                trial.count(!is_wrong, 0.0, [&] { return fmt::format("pixel {}, {}", x, y); });
            }
        trial.report();
    }
}

namespace {

scene::SceneData make_horizon_scene(test::Random& random) {
    const test::WorldSettings world{
        .seed = random.below(1000), .origin = {3e5, 12.0, -2e5}, .height_grid_size = 16u << random.below(4)};
    switch (random.below(4)) {
        case 0:
            return test::make_city({.cells = 3, .subdivisions = 2}, world);
        case 1:
            return test::make_forest({.trees = 60, .leaves = 40}, world);
        case 2:
            return test::make_terrain({.spacing_m = 50.0}, world);
        default:
            return test::make_triangle_soup({.triangles = 300, .edge_m = 8.0}, world);
    }
}

/// Anywhere, or a hair beside some triangle's corner: a wall, a roof's edge, a leaf.
WorldPos place_eye_in(test::Random& random, const scene::StaticScene& scene) {
    if (random.below(2) == 0)
        return WorldPos(random.in(scene.bounds.low.x, scene.bounds.high.x),
                        random.in(scene.bounds.low.y, 1.5 * scene.bounds.high.y),
                        random.in(scene.bounds.low.z, scene.bounds.high.z));
    const scene::Instance& instance = scene.instances[random.below(std::uint32_t(scene.instances.size()))];
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const Vec3& corner = scene.positions[mesh.first_vertex + random.below(mesh.vertex_count)];
    const DVec3 hair = std::pow(10.0, random.in(-6.0, 0.0)) * DVec3(random.in_box(Vec3(-1.0f), Vec3(1.0f)));
    return instance.position + DMat3(instance.world_from_mesh) * DVec3(corner) + hair;
}

}  // namespace

void horizon_over_scenes(Trial& trial) {
    PixelMask sky;
    farfield::VisibilityBuffer seen;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const scene::SceneData data = make_horizon_scene(random);
        const scene::StaticScene scene = data.view();
        const auto caster = make_caster(Subject::embree, scene);
        for (int views = 0; views < 8; ++views) {
            Camera camera;
            camera.position = place_eye_in(random, scene);
            turn_camera(random, camera);
            const PinholeView view = make_view(camera, kWidth, kHeight);
            HorizonMap map(random_settings(random, 0.0));
            map.set_quality(0.0f, map.settings().subsample);
            test::walk_to(scene, view, std::pow(10.0, random.in(-4.0, 0.0)), random.below(1u << 20), map);
            find_sky_pixels(view, map, sky);
            seen.resize(kWidth, kHeight);
            caster->cast_tiles(view, all_tiles(view), seen);
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) {
                    const std::size_t at = seen.index(x, y);
                    const bool is_wrong = sky.test(x, y) && seen.instance[at] != farfield::kSkyInstance;
                    trial.count(!is_wrong, 0.0,
                                [&] { return fmt::format("pixel {}, {}: a hit at {} m", x, y, seen.depth[at]); });
                }
        }
        trial.report();
    }
}

}  // namespace ff::hardcases
