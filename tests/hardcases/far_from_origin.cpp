// The whole pipeline far from the world's origin: the same picture as at it, and steps that do not jitter.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <memory>

#include "engine/frame/renderer.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr DVec3 kFraction(0.37, 0.11, 0.53);  ///< of a metre: nothing falls on round numbers there
constexpr int kLevels = 3;                    ///< of 255; pixels off by more in some channel differ

/// A scene, moved away from the origin, and what draws it.
struct Place {
    Place(scene::SceneData source, const WorldPos& moved)
        : data(std::move(source)),
          scene(data.view()),
          casters(scene),
          renderer(scene, casters, nullptr, kWidth, kHeight),
          offset(moved) {}

    void draw(Camera camera) {
        camera.position += offset;
        stats = renderer.draw(camera, {}, {.fixed_near_m = 0.0, .deterministic = true}, image);
    }

    scene::SceneData data;
    scene::StaticScene scene;
    frame::Casters casters;
    frame::Renderer renderer;
    WorldPos offset;
    shading::Image image;
    frame::FrameStats stats;
};

scene::SceneData make_scene(std::uint32_t kind, std::uint32_t seed, const WorldPos& moved) {
    const test::WorldSettings world{.seed = seed, .origin = moved, .height_grid_size = 128};
    switch (kind) {
        case 0:
            return test::make_city({.cells = 3, .subdivisions = 2}, world);
        case 1:
            return test::make_forest({.trees = 150, .size_m = 120.0, .leaves = 80}, world);
        default:
            return test::make_terrain({.size_m = 3000.0, .spacing_m = 40.0}, world);
    }
}

/// A few steps and a few turns of somebody who walks there.
Camera step_camera(test::Random& random, const Camera& start, int step) {
    Camera camera = start;
    if (step < 4) {
        camera.position += 0.03 * double(step) * DVec3(std::sin(camera.yaw), 0.0, -std::cos(camera.yaw));
    } else {
        camera.position += 0.09 * DVec3(std::sin(camera.yaw), 0.0, -std::cos(camera.yaw));
        camera.yaw += 0.02 * double(step - 3) + 1e-3 * random.unit();
    }
    return camera;
}

Camera start_camera(test::Random& random, const scene::StaticScene& scene) {
    Camera camera{.position = {random.in(-50.0, 50.0), 0.0, random.in(-50.0, 50.0)},
                  .yaw = random.in(-kPi, kPi),
                  .pitch = random.in(-0.3, 0.3)};
    camera.position.y = random.below(2) == 0 ? 1.7 : random.in(0.5, 1.2) * scene.bounds.high.y;
    return camera;
}

bool differs(std::uint32_t a, std::uint32_t b) {
    for (int shift = 0; shift < 24; shift += 8)
        if (std::abs(int(a >> shift & 255u) - int(b >> shift & 255u)) > kLevels) return true;
    return false;
}

/// Counts pixels of the frame by how far the depth is from the plane of the triangle that they show, in pixels of
/// parallax: were the viewer's position rounded, all would be off by as much.
void count_shifts(const Place& place, Trial& trial) {
    const PinholeView& view = place.renderer.plan().view;
    const farfield::VisibilityBuffer& seen = place.renderer.history().visibility;
    for (int y = 0; y < view.height; y += 3)
        for (int x = 0; x < view.width; x += 3) {
            const std::size_t at = seen.index(x, y);
            if (seen.instance[at] >= place.scene.instances.size()) continue;
            const scene::Instance& instance = place.scene.instances[seen.instance[at]];
            const scene::Mesh& mesh = place.scene.meshes[instance.mesh];
            const std::size_t index = 3 * (std::size_t(mesh.first_triangle) + seen.triangle[at]);
            DVec3 p[3];
            for (std::size_t k = 0; k < 3; ++k)
                p[k] = DMat3(instance.world_from_mesh) *
                           DVec3(place.scene.positions[mesh.first_vertex + place.scene.indices[index + k]]) +
                       (instance.position - view.position);
            const DVec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
            const auto depth = double(seen.depth[at]);
            const double off_m = glm::dot(normal, depth * DVec3(view.direction(x, y)) - p[0]);
            trial.count(true, std::fabs(off_m) / (depth * double(view.pixel_angle())), [] { return std::string(); });
        }
}

}  // namespace

template <int kDistanceM>
void picture_far_away(Trial& trial) {
    while (!trial.done()) {
        const std::uint32_t seed = trial.next_seed();
        test::Random random(seed);
        const std::uint32_t kind = random.below(3);
        const WorldPos moved = double(kDistanceM) * DVec3(random.below(2) == 0 ? 1 : -1, 0.001, 0.7) + kFraction;
        Place here(make_scene(kind, seed, WorldPos(0.0)), WorldPos(0.0));
        Place there(make_scene(kind, seed, moved), moved);
        const Camera start = start_camera(random, here.scene);
        for (int step = 0; step < 12; ++step) {
            const Camera camera = step_camera(random, start, step);
            trial.time_easy([&] { here.draw(camera); });
            trial.time_hard([&] { there.draw(camera); });
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) {
                    const std::size_t at = std::size_t(y) * std::size_t(here.image.stride) + std::size_t(x);
                    trial.count(!differs(here.image.pixels[at], there.image.pixels[at]), 0.0, [&] {
                        return fmt::format("pixel {}, {} of step {}: {:06x}, at the origin {:06x}", x, y, step,
                                           there.image.pixels[at] & 0xFFFFFFu, here.image.pixels[at] & 0xFFFFFFu);
                    });
                }
        }
        trial.report();
    }
}
template void picture_far_away<1000>(Trial&);
template void picture_far_away<1000000>(Trial&);
template void picture_far_away<10000000>(Trial&);

void walk_far_away(Trial& trial) {
    constexpr double kDistanceM = 1e7;
    while (!trial.done()) {
        const std::uint32_t seed = trial.next_seed();
        test::Random random(seed);
        const WorldPos moved = kDistanceM * DVec3(0.7, 0.001, -1.0) + kFraction;
        const std::uint32_t kind = random.below(2) * 2;
        Place there(make_scene(kind, seed, moved), moved);
        Camera camera{.yaw = random.in(-kPi, kPi), .pitch = random.in(-0.3, 0.1)};
        camera.position.y = kind == 0 ? 1.7 : 90.0;
        for (int step = 0; step < 30; ++step) {
            camera.position += 0.0123 * DVec3(std::sin(camera.yaw), 0.0, -std::cos(camera.yaw));
            there.draw(camera);
            count_shifts(there, trial);
        }
        trial.report();
    }
}

}  // namespace ff::hardcases
