#include "engine/frame/renderer.h"

#include "engine/core/check.h"
#include "engine/core/stopwatch.h"

namespace ff::frame {
namespace {

void learn_costs(const FrameStats& stats, budget::CostModel& costs) {
    costs.cast_ray.observe(stats.ms(Pass::cast), double(stats.rays));
    costs.shade_pixel.observe(stats.ms(Pass::shade), double(stats.shaded_pixels));
    const auto looked_up = double(stats.pixels.panorama + stats.pixels.cast_hit + stats.pixels.cast_miss);
    if (stats.ms(Pass::panorama) > 0.0) costs.lookup_pixel.observe(stats.ms(Pass::panorama), looked_up);
    if (stats.ms(Pass::store) > 0.0) costs.store_pixel.observe(stats.ms(Pass::store), double(stats.rays));
    if (stats.near_triangles > 0)
        costs.near_triangle.observe(stats.ms(Pass::near_field) - costs.near_fixed_ms, double(stats.near_triangles));
}

}  // namespace

Renderer::Renderer(const scene::StaticScene& scene, Casters& casters, nearfield::NearRenderer* near_renderer, int width,
                   int height)
    : tools_{scene, casters, near_renderer}, width_(width), height_(height) {
    FF_CHECK(width > 0 && height > 0 && width <= 16384 && height <= 16384, "image of {} x {}", width, height);
    reset();
}

void Renderer::reset() {
    history_.reset(width_, height_);
}

const FrameStats& Renderer::draw(const Camera& camera, std::span<const scene::Instance> dynamic,
                                 const FrameSettings& settings, shading::Image& image) {
    const Stopwatch watch;
    plan_frame(tools_.scene, dynamic, camera, width_, height_, settings, history_, plan_);
    const double plan_ms = watch.milliseconds();
    history_.last_stats = run_passes(plan_, tools_, history_, image);
    FrameStats& stats = history_.last_stats;
    stats.ms(Pass::plan) = plan_ms;
    stats.frame_ms = watch.milliseconds();
    if (plan_.mode == Mode::hybrid) learn_costs(stats, history_.costs);
    history_.last_view = plan_.view;
    history_.has_frame = true;
    ++history_.frame_number;
    return stats;
}

}  // namespace ff::frame
