#include "engine/frame/renderer.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/stopwatch.h"
#include "engine/core/work_clock.h"
#include "engine/effects/wind.h"
#include "engine/frame/check_input.h"
#include "engine/nearfield/near_renderer.h"

namespace ff::frame {
namespace {

void learn_costs(const FramePlan& plan, const FrameStats& stats, budget::CostModel& costs) {
    // The few rays that a full panorama leaves cost several times as much each as those of whole tiles.
    const bool casts_remains = plan.look_up_panorama && !plan.store_panorama;
    if (!casts_remains) {
        costs.cast_ray.observe(stats.ms(Pass::cast), double(stats.rays));
        // Transparent layers are shading, too: there are as many more as there are pixels.
        costs.shade_pixel.observe(stats.ms(Pass::sun) + stats.ms(Pass::shade) + stats.ms(Pass::blend),
                                  double(stats.shaded_pixels));
    }
    if (stats.ms(Pass::upscale) > 0.0)
        costs.upscale_pixel.observe(stats.ms(Pass::upscale), double(plan.image_width) * plan.image_height);
    const auto looked_up = double(stats.pixels.panorama + stats.pixels.cast_hit + stats.pixels.cast_miss);
    if (stats.ms(Pass::panorama) > 0.0) costs.lookup_pixel.observe(stats.ms(Pass::panorama), looked_up);
    if (stats.ms(Pass::store) > 0.0) costs.store_pixel.observe(stats.ms(Pass::store), double(stats.rays));
    costs.horizon_azimuth.observe(stats.ms(Pass::horizon), double(stats.horizon_azimuths));
    if (stats.near_triangles > 0)
        costs.near_triangle.observe(stats.ms(Pass::near_field) - costs.near_fixed_ms, double(stats.near_triangles));
}

/// What OpenGL costs with nothing to draw: the near field's price of entry on this machine. Median of five.
double measure_near_fixed_ms(nearfield::NearRenderer& near_renderer, int width, int height) {
    farfield::VisibilityBuffer visibility;
    nearfield::NearStats stats;
    const PinholeView view = make_view({}, width, height);
    std::array<double, 5> times;
    for (double& time : times) {
        const Stopwatch watch;
        if (!near_renderer.render_ids(view, {}, visibility, stats)) return std::numeric_limits<double>::infinity();
        time = watch.milliseconds();
    }
    std::nth_element(times.begin(), times.begin() + 2, times.end());
    return times[2];
}

/// A box around what stands in it and the shadow that this casts, as far as the scene goes.
DBox3 with_shadow(const scene::StaticScene& scene, const DBox3& box) {
    if (box.is_empty() || scene.bounds.is_empty()) return box;
    const double reach_m = glm::length(scene.bounds.high - scene.bounds.low);
    const DVec3 along = -DVec3(scene.environment.to_sun) * reach_m;
    DBox3 out{glm::min(box.low, box.low + along), glm::max(box.high, box.high + along)};
    // Below the scene there is nothing to be shaded.
    if (const double fall_m = box.high.y - scene.bounds.low.y; along.y < 0.0 && fall_m < -along.y) {
        const DVec3 landed = along * std::max(0.0, fall_m / -along.y);
        out = {glm::min(box.low, box.low + landed), glm::max(box.high, box.high + landed)};
    }
    return out;
}

}  // namespace

Renderer::Renderer(const scene::StaticScene& scene, Casters& casters, nearfield::NearRenderer* near_renderer, int width,
                   int height)
    : source_(scene),
      drawn_(scene),
      culler_(scene),
      dynamic_overlay_(scene),
      layer_index_(farfield::make_layer_index(scene)),
      lamps_(scene.lamps),
      water_(effects::find_material(scene, scene::kMaterialWater)),
      mirrors_(effects::find_material(scene, scene::kMaterialMirror)),
      facts_{.layer_index = &layer_index_,
             .lamps = &lamps_,
             .water = water_,
             .mirrors = mirrors_,
             .has_foliage = effects::has_foliage(scene)},
      tools_{drawn_, casters, culler_, dynamic_overlay_, layer_index_, facts_, near_renderer},
      width_(width),
      height_(height) {
    FF_CHECK(width > 0 && height > 0 && width <= kMaxSidePx && height <= kMaxSidePx, "image of {} x {}", width, height);
    if (near_renderer != nullptr) {
        history_.can_rasterise = true;
        history_.costs.near_fixed_ms = measure_near_fixed_ms(*near_renderer, width, height);
    }
    reset();
}

void Renderer::reset() {
    history_.reset(width_, height_);
}

void Renderer::region_changed(const DBox3& box) {
    const DBox3 touched = history_.sun ? with_shadow(tools_.scene, box) : box;
    if (history_.panorama && history_.panorama->invalidate(touched, history_.panorama_reflections != nullptr) > 0)
        history_.panorama_is_full = false;
    if (history_.reprojection) history_.reprojection->invalidate(box);
    if (history_.sun) history_.sun->history.clear();
    if (history_.shelter) history_.shelter->clear();
    history_.horizon.invalidate();
}

const FrameStats& Renderer::refuse(Error reason, shading::Image& image) {
    refusal_ = std::move(reason);
    if (image.width != width_ || image.height != height_) image.resize(width_, height_);
    refused_stats_ = {};
    refused_stats_.refused = true;
    return refused_stats_;
}

const FrameStats& Renderer::draw(const Camera& camera, std::span<const scene::Instance> dynamic,
                                 const FrameSettings& settings, shading::Image& image) {
    const std::int64_t begin_ns = steady_ns(), begin_work_ns = work_ns();
    if (const Status input = check_frame_input(source_, camera, dynamic, settings); !input)
        return refuse(input.error(), image);
    refusal_ = {};
    plan_frame(source_, facts_, dynamic, camera, width_, height_, settings, history_, plan_);
    drawn_ = source_;
    drawn_.environment = plan_.environment;
    const std::int64_t planned_ns = steady_ns(), planned_work_ns = work_ns();
    history_.last_stats = run_passes(plan_, tools_, history_, image);
    FrameStats& stats = history_.last_stats;
    for (const effects::EffectId id : {effects::EffectId::birds, effects::EffectId::rigid_bodies}) {
        const effects::Simulation& simulation = settings.simulations[id];
        if (stats.effects[id].state != effects::State::off)
            stats.work(id) = {
                .ms = simulation.ms, .allocations = simulation.allocations, .systems = simulation.systems};
    }
    stats.ms(Pass::plan) = 1e-6 * double(planned_work_ns - begin_work_ns);
    stats.log.begin_ns = begin_ns;
    stats.log.end_ns = steady_ns();
    stats.log.add({.begin_ns = begin_ns, .end_ns = planned_ns, .index = std::uint8_t(Pass::plan)});
    stats.frame_ms = 1e-6 * double(work_ns() - begin_work_ns) - stats.untimed_ms;
    if (plan_.mode == Mode::hybrid) learn_costs(plan_, stats, history_.costs);
    history_.last_view = plan_.view;
    history_.last_mode = plan_.mode;
    history_.has_frame = true;
    ++history_.frame_number;
    return stats;
}

}  // namespace ff::frame
