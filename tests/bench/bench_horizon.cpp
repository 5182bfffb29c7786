// Horizon tracing over a 1024 x 1024 grid on one core: all 1,280 azimuths, those of a view, and the sky pixels.
#include <benchmark/benchmark.h>

#include <cmath>

#include "engine/core/jobs.h"
#include "engine/farfield/horizon.h"
#include "tests/farfield/horizon_worlds.h"
#include "tests/support/worlds.h"

namespace {

using namespace ff;
using farfield::HorizonMap;

const WorkerLimit kOneCore(1);

const test::OwnedHeightGrid& valley() {
    static const test::OwnedHeightGrid world = test::make_valley_grid(1024, 30.0, 7);
    return world;
}

/// Where the eye is in a frame of a walk: 5 m/s at 30 frames a second, or a flight far above.
WorldPos eye_at(int frame, double height) {
    const double angle = 0.002 * frame;
    return {300.0 * std::cos(angle) + 13.7, height, 300.0 * std::sin(angle) + 5.1};
}

/// Arguments: eye height in metres, subsample, near distance.
void all_azimuths_while_walking(benchmark::State& state) {
    HorizonMap map({.near_distance_m = float(state.range(2)), .subsample = int(state.range(1))});
    map.update(valley().grid, eye_at(-1, double(state.range(0))), {0, map.settings().columns});
    int frame = 0;
    std::uint64_t squares = 0;
    for (auto _ : state) {
        const auto cost =
            map.update(valley().grid, eye_at(frame++, double(state.range(0))), {0, map.settings().columns});
        squares += cost.squares;
        benchmark::DoNotOptimize(map.tangents().data());
    }
    state.counters["squares"] = benchmark::Counter(double(squares), benchmark::Counter::kAvgIterations);
}
BENCHMARK(all_azimuths_while_walking)
    ->ArgsProduct({{2, 20, 40, 80, 150, 300, 600, 1000}, {1, 2, 4}, {0, 100}})
    ->ArgNames({"eye_m", "subsample", "near_m"})
    ->Unit(benchmark::kMicrosecond);

/// As after a jump: nothing is known of the last frame.
void all_azimuths_from_nothing(benchmark::State& state) {
    HorizonMap map;
    int frame = 0;
    for (auto _ : state) {
        map.invalidate();
        map.update(valley().grid, eye_at(137 * frame++, double(state.range(0))), {0, map.settings().columns});
        benchmark::DoNotOptimize(map.tangents().data());
    }
}
BENCHMARK(all_azimuths_from_nothing)->Arg(2)->Arg(80)->Arg(1000)->ArgName("eye_m")->Unit(benchmark::kMicrosecond);

/// In a street of a town whose grid squares (64 m) hold houses: the scene's boxes around the eye count, too.
void all_azimuths_in_a_street(benchmark::State& state) {
    static const scene::SceneData town = test::make_city({.cells = 8, .subdivisions = 4}, {.height_grid_size = 64});
    const scene::StaticScene scene = town.view();
    HorizonMap map({.fine_squares = int(state.range(0))});
    int frame = 0;
    farfield::HorizonCost cost;
    for (auto _ : state) {
        cost = map.update(scene, scene.origin + DVec3(0.05 * (frame++ % 1000), 2.0 - scene.origin.y, 3.0),
                          {0, map.settings().columns});
        benchmark::DoNotOptimize(map.tangents().data());
    }
    double known = 0.0;
    for (const float tangent : map.tangents()) known += tangent < 10.0f ? 1.0 : 0.0;
    state.counters["boxes"] = double(cost.boxes);
    state.counters["squares"] = double(cost.squares);
    state.counters["columns_with_sky_pct"] = 100.0 * known / double(map.settings().columns);
}
BENCHMARK(all_azimuths_in_a_street)->Arg(0)->Arg(1)->Arg(3)->ArgName("fine_squares")->Unit(benchmark::kMicrosecond);

PinholeView view_at(int frame, double height, double pitch, double roll) {
    Camera camera;
    camera.position = eye_at(frame, height);
    camera.yaw = 0.01 * frame;
    camera.pitch = pitch;
    camera.roll = roll;
    return make_view(camera, 640, 480);
}

void azimuths_of_a_view_while_walking(benchmark::State& state) {
    HorizonMap map;
    int frame = 0;
    for (auto _ : state) {
        map.update(valley().grid, view_at(frame++, double(state.range(0)), 0.0, 0.0));
        benchmark::DoNotOptimize(map.tangents().data());
    }
}
BENCHMARK(azimuths_of_a_view_while_walking)->Arg(2)->Arg(80)->ArgName("eye_m")->Unit(benchmark::kMicrosecond);

void sky_pixels_640x480(benchmark::State& state) {
    HorizonMap map;
    farfield::PixelMask sky;
    const PinholeView view = view_at(3, 80.0, radians_of(double(state.range(0))), radians_of(double(state.range(1))));
    map.update(valley().grid, view);
    std::uint64_t found = 0;
    for (auto _ : state) {
        found = farfield::find_sky_pixels(view, map, sky);
        benchmark::DoNotOptimize(sky.tiles.data());
    }
    state.counters["sky_pct"] = 100.0 * double(found) / (640.0 * 480.0);
}
BENCHMARK(sky_pixels_640x480)
    ->Args({0, 0})
    ->Args({10, 25})
    ->Args({-30, 0})
    ->Args({80, 0})
    ->ArgNames({"pitch_deg", "roll_deg"})
    ->Unit(benchmark::kMicrosecond);

void the_plain_reference(benchmark::State& state) {
    std::vector<double> tangents(1280);
    for (auto _ : state) {
        farfield::trace_horizon_reference(valley().grid, eye_at(1, 80.0), 0.0f, tangents);
        benchmark::DoNotOptimize(tangents.data());
    }
}
BENCHMARK(the_plain_reference)->Unit(benchmark::kMillisecond)->Iterations(2);

}  // namespace
