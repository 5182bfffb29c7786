// Numbers that are none, in camera, settings and moving instances: refused before anything is drawn.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/frame/check_input.h"
#include "engine/frame/renderer.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

/// Everything that a frame is drawn of.
struct FrameInput {
    Camera camera;
    frame::FrameSettings settings;
    std::vector<scene::Instance> dynamic;
};

FrameInput good_input(test::Random& random, const scene::StaticScene& scene) {
    FrameInput input;
    input.camera = test::random_camera(random, scene.bounds);
    input.settings = {.budget_ms = random.below(2) == 0 ? 0.0 : random.in(1.0, 30.0), .fixed_near_m = 0.0};
    for (std::uint32_t i = 0; i < 1 + random.below(3); ++i) {
        scene::Instance instance = scene.instances[random.below(std::uint32_t(scene.instances.size()))];
        instance.position += DVec3(random.in_box(Vec3(-50.0f), Vec3(50.0f)));
        input.dynamic.push_back(instance);
    }
    return input;
}

void spoil(test::Random& random, farfield::ReprojectSettings& settings) {
    switch (random.below(6)) {
        case 0:
            settings.surface_share = random.below(2) == 0 ? std::numeric_limits<float>::quiet_NaN() : -0.5f;
            break;
        case 1:
            settings.min_count = random.below(2) == 0 ? -1 : 10;
            break;
        case 2:
            settings.resample_period = random.below(2) == 0 ? -1 : 65;
            break;
        case 3:
            settings.resample_block_px = random.below(2) == 0 ? 0 : 64;
            break;
        case 4:
            settings.resample_block_px = 3;
            break;
        default:
            settings.abrupt_frames = random.below(2) == 0 ? 0 : 65;
    }
}

/// Puts something that is no number, or none that can be, into one place.
void spoil(test::Random& random, FrameInput& input) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    const double bad = std::array{std::numeric_limits<double>::quiet_NaN(), kInf, -kInf}[random.below(3)];
    const auto axis = int(random.below(3));
    scene::Instance& instance = input.dynamic[random.below(std::uint32_t(input.dynamic.size()))];
    switch (random.below(18)) {
        case 0:
            input.camera.position[axis] = bad;
            break;
        case 1:
            input.camera.yaw = bad;
            break;
        case 2:
            input.camera.pitch = bad;
            break;
        case 3:
            input.camera.roll = bad;
            break;
        case 4:
            input.camera.vertical_fov = random.below(2) == 0 ? bad : random.in(-1.0, 0.0);
            break;
        case 5:
            input.settings.budget_ms = random.below(2) == 0 ? bad : -1.0;
            break;
        case 6:
            input.settings.fixed_near_m = bad;
            break;
        case 7:
            input.settings.max_parallax_px = float(bad);
            break;
        case 8:
            input.settings.prelit_beyond_m = std::isnan(bad) ? float(bad) : -1.0f;
            break;
        case 13:
            (random.below(2) == 0 ? input.settings.blend_within_m : input.settings.wind_within_m) = float(bad);
            (random.below(2) == 0 ? input.settings.air_error : input.settings.water_within_m) = float(bad);
            break;
        case 14:
            input.settings.grid_cells_per_item = float(bad);
            break;
        case 15:
            input.settings.resolution = float(bad);
            break;
        case 16:
            input.settings.panorama_density = float(bad);
            break;
        case 17:
            spoil(random, input.settings.reproject);
            break;
        case 9:
            instance.position[axis] = bad;
            break;
        case 10:
            instance.world_from_mesh[axis][int(random.below(3))] = float(bad);
            break;
        case 11:
            instance.world_from_mesh[axis] = Vec3(0.0f);
            break;
        default:
            (random.below(2) == 0 ? instance.bounds.low : instance.bounds.high)[axis] = bad;
    }
}

}  // namespace

void bad_numbers_refused(Trial& trial) {
    const scene::SceneData data = test::make_city({.cells = 2}, {.height_grid_size = 16});
    const scene::StaticScene scene = data.view();
    constexpr int kInputs = 1000;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        for (int i = 0; i < kInputs; ++i) {
            FrameInput input = good_input(random, scene);
            const bool is_good = bool(check_frame_input(scene, input.camera, input.dynamic, input.settings));
            spoil(random, input);
            const Status status = check_frame_input(scene, input.camera, input.dynamic, input.settings);
            const bool is_refused = !status && !status.error().message.empty();
            trial.count(is_good && is_refused, 0.0, [&] {
                return fmt::format("input {}: {}", i, is_good ? "spoilt, but taken" : "good, but refused");
            });
        }
        trial.report();
    }
}

void bad_numbers_never_drawn(Trial& trial) {
    constexpr int kWidth = 48, kHeight = 32;
    const scene::SceneData data = test::make_city({.cells = 2}, {.height_grid_size = 16});
    const scene::StaticScene scene = data.view();
    frame::Casters casters(scene);
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        frame::Renderer troubled(scene, casters, nullptr, kWidth, kHeight),
            calm(scene, casters, nullptr, kWidth, kHeight);
        shading::Image image, expected;
        FrameInput input = good_input(random, scene);
        input.settings.deterministic = true;
        for (int step = 0; step < 4; ++step) {
            input.camera.yaw += 0.01;
            troubled.draw(input.camera, input.dynamic, input.settings, image);
            calm.draw(input.camera, input.dynamic, input.settings, expected);
            // A bad frame in between: not a pixel of it is drawn, and the next good one is as if it had not been.
            FrameInput bad = input;
            spoil(random, bad);
            const bool is_refused = troubled.draw(bad.camera, bad.dynamic, bad.settings, image).refused;
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) {
                    const std::size_t at = std::size_t(y) * std::size_t(image.stride) + std::size_t(x);
                    trial.count(is_refused && image.pixels[at] == expected.pixels[at], 0.0,
                                [&] { return fmt::format("pixel {}, {} of step {}", x, y, step); });
                }
        }
        trial.report();
    }
}

}  // namespace ff::hardcases
