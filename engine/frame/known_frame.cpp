#include "engine/frame/known_frame.h"

#include "engine/core/stopwatch.h"
#include "engine/farfield/known_pixels.h"
#include "engine/frame/shade_settings.h"
#include "engine/frame/timed_pass.h"

namespace ff::frame {

void draw_known_frame(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
                      FrameStats& stats) {
    farfield::VisibilityBuffer& visibility = history.visibility;
    {
        const Stopwatch watch;
        tools.casters.get(plan.caster).cast_tiles(plan.view, history.all_tiles, visibility);
        if (image.width != plan.view.width || image.height != plan.view.height)
            image.resize(plan.view.width, plan.view.height);
        stats.untimed_ms = watch.milliseconds();
    }
    {
        const TimedPass timed(stats, Pass::verify);
        const farfield::CastCost cost =
            farfield::cast_known_pixels(tools.scene, plan.view, history.all_tiles, visibility);
        stats.pixels.verified = stats.rays = cost.rays;
        stats.triangles_tested = cost.triangles;
    }
    stats.pixels.sky = std::uint64_t(plan.view.width) * std::uint64_t(plan.view.height) - stats.pixels.verified;
    if (!plan.dynamic.empty()) {
        const TimedPass timed(stats, Pass::cast);
        tools.dynamic_overlay.draw(plan.view, plan.dynamic, history.all_tiles, visibility, history.sources.dynamic);
        stats.pixels.dynamic = history.sources.dynamic.count();
    }
    const std::uint8_t* const sun_seen =
        find_sun(plan, tools.scene, visibility, history.all_tiles, nullptr, history.sun, stats);
    const shading::Reflections* const reflections = find_reflections(plan, tools, history.all_tiles, history, stats);
    const TimedPass timed(stats, Pass::shade);
    stats.shaded_pixels = shading::shade_tiles(
        tools.scene, plan.dynamic, plan.view, visibility, history.all_tiles,
        shade_settings(plan, tools, plan.view, sun_seen, history.lights, stats, reflections), image);
}

}  // namespace ff::frame
