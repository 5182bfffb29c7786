// What OpenGL costs here: ids and shaded pictures of a city of a growing number of triangles, culled and front to back.
// Times are of all threads together (llvmpipe uses as many as there are cores), so that a busy machine tells the truth.

#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <cstdlib>

#include "engine/nearfield/near_renderer.h"
#include "engine/platform/headless.h"
#include "engine/visibility/culler.h"
#include "tests/support/worlds.h"

namespace {

using namespace ff;

template <class T>
T value_or_exit(Result<T> result) {
    if (!result) {
        fmt::print(stderr, "{}\n", result.error().message);
        std::exit(1);
    }
    return std::move(*result);
}

template <class Render>
void draw_world(benchmark::State& state, const scene::SceneData& world, bool occlusion, Render&& render) {
    const auto context = value_or_exit(platform::HeadlessContext::open());
    const scene::StaticScene scene = world.view();
    auto renderer = value_or_exit(nearfield::NearRenderer::make(scene));
    if (!occlusion) renderer.set_occlusion({.enabled = false});
    const PinholeView view = make_view({.position = {3.0, 1.7, 5.0}, .yaw = 0.4, .pitch = -0.05}, 640, 480);
    visibility::VisibleSet visible;
    visibility::Culler(scene).cull(view, {}, visible);
    nearfield::NearStats stats;
    for (auto _ : state) {
        stats = {};
        if (!render(renderer, view, nearfield::DrawSet{.instances = visible.instances}, stats)) std::exit(1);
    }
    state.counters["triangles"] = double(stats.triangles);
    state.counters["draws"] = double(stats.draws);
    state.counters["calls"] = double(stats.calls);
}

/// range(0): quads along each edge of each box; 12,288 times its square is the number of triangles.
template <class Render>
void draw_city(benchmark::State& state, Render&& render) {
    draw_world(state, test::make_city({.cells = 8, .subdivisions = int(state.range(0))}), false, render);
}

/// range(0): 1 with culling by occlusion. In the city much is hidden, on open hills nothing is: there it may not cost.
void near_ids_of(benchmark::State& state, const scene::SceneData& world) {
    farfield::VisibilityBuffer buffer;
    draw_world(state, world, state.range(0) != 0,
               [&](auto& renderer, const PinholeView& view, const nearfield::DrawSet& set, auto& stats) {
                   return bool(renderer.render_ids(view, set, buffer, stats));
               });
}

void near_ids_of_city(benchmark::State& state) {
    near_ids_of(state, test::make_city({.cells = 16, .subdivisions = 5}));
}

void near_ids_of_flat_ground(benchmark::State& state) {
    near_ids_of(state, test::make_terrain({.size_m = 2000.0, .spacing_m = 5.0, .relief_m = 0.0}));
}

void near_ids(benchmark::State& state) {
    farfield::VisibilityBuffer buffer;
    draw_city(state, [&](auto& renderer, const PinholeView& view, const nearfield::DrawSet& set, auto& stats) {
        return bool(renderer.render_ids(view, set, buffer, stats));
    });
}

void shaded_picture(benchmark::State& state) {
    shading::Image image;
    draw_city(state, [&](auto& renderer, const PinholeView& view, const nearfield::DrawSet& set, auto& stats) {
        return bool(renderer.render_shaded(view, set, image, stats));
    });
}

BENCHMARK(near_ids_of_city)->Arg(0)->Arg(1)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK(near_ids_of_flat_ground)->Arg(0)->Arg(1)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK(near_ids)->Arg(1)->Arg(3)->Arg(9)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK(shaded_picture)->Arg(1)->Arg(3)->Arg(9)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}  // namespace
