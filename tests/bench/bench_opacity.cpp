// The opacity buffer on one core: small triangles a second, and a street at 640 x 480.
#include <benchmark/benchmark.h>

#include <numeric>

#include "engine/farfield/opacity_buffer.h"
#include "tests/support/worlds.h"

namespace {

using namespace ff;

std::vector<std::uint32_t> all_of(const scene::StaticScene& scene) {
    std::vector<std::uint32_t> ids(scene.instances.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

/// Terrain seen from above, so that nothing hides anything: triangles of about 7 pixels. Argument: 1: tiles start
/// uncovered each time (as always).
void small_triangles(benchmark::State& state) {
    static const scene::SceneData world =
        test::make_terrain({.size_m = 1000.0, .spacing_m = 1.5625, .relief_m = 30.0}, {.height_grid_size = 16});
    const scene::StaticScene scene = world.view();
    const auto ids = all_of(scene);
    Camera camera;
    camera.position = {0.0, double(state.range(0)), 0.0};
    camera.pitch = -kPi / 2;
    const PinholeView view = make_view(camera, 640, 480);
    farfield::OpacityRaster raster;
    farfield::PixelMask covered;
    std::uint64_t triangles = 0, drawn = 0, pixels = 0;
    for (auto _ : state) {
        const auto cost = raster.draw(scene, {}, ids, view, covered);
        triangles += cost.triangles;
        drawn += cost.drawn;
    }
    pixels = covered.count();
    state.counters["triangles/s"] = benchmark::Counter(double(triangles), benchmark::Counter::kIsRate);
    state.counters["drawn/s"] = benchmark::Counter(double(drawn), benchmark::Counter::kIsRate);
    state.counters["triangles"] = benchmark::Counter(double(triangles), benchmark::Counter::kAvgIterations);
    state.counters["covered_pct"] = 100.0 * double(pixels) / (640.0 * 480.0);
}
BENCHMARK(small_triangles)->Arg(200)->Arg(500)->Arg(1000)->ArgName("eye_m")->Unit(benchmark::kMicrosecond);

/// Argument: the nearest how many metres are the near field.
void street_640x480(benchmark::State& state) {
    static const scene::SceneData world = test::make_city({.cells = 4, .subdivisions = 6});
    const scene::StaticScene scene = world.view();
    Camera camera;
    camera.position = {0.0, 1.7, 3.0};
    camera.yaw = 0.3;
    const PinholeView view = make_view(camera, 640, 480);
    std::vector<std::uint32_t> ids;
    for (const std::uint32_t id : all_of(scene))
        if (distance_to(scene.instances[id].bounds, camera.position) < double(state.range(0))) ids.push_back(id);
    farfield::OpacityRaster raster;
    farfield::PixelMask covered;
    farfield::OpacityCost cost;
    for (auto _ : state) cost = raster.draw(scene, {}, ids, view, covered);
    state.counters["leaves"] = double(cost.leaves);
    state.counters["triangles"] = double(cost.triangles);
    state.counters["covered_pct"] = 100.0 * double(covered.count()) / (640.0 * 480.0);
}
BENCHMARK(street_640x480)->Arg(100)->Arg(400)->Arg(10000)->ArgName("near_m")->Unit(benchmark::kMicrosecond);

void from_depth_640x480(benchmark::State& state) {
    std::vector<float> depth(640 * 480, 1.0f);
    farfield::PixelMask covered;
    for (auto _ : state) farfield::opacity_from_depth(depth.data(), 640, 640, 480, farfield::EmptyDepth::zero, covered);
}
BENCHMARK(from_depth_640x480)->Unit(benchmark::kMicrosecond);

}  // namespace
