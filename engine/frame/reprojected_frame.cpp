#include "engine/frame/reprojected_frame.h"

#include "engine/farfield/reproject_cast.h"
#include "engine/farfield/tile_regroup.h"
#include "engine/frame/shade_settings.h"
#include "engine/frame/timed_pass.h"

namespace ff::frame {
namespace {

/// Answers what it can; the rest is left in history.requests.
/// @return whether anything was reprojected
bool reproject(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats) {
    if (!history.reprojection) history.reprojection = std::make_unique<farfield::Reprojection>(tools.scene);
    farfield::Reprojection& reprojection = *history.reprojection;
    bool has_landed = false;
    {
        const TimedPass timed(stats, Pass::reproject);
        has_landed = reprojection.reproject(history.last_view, history.visibility, plan.view, plan.reproject);
    }
    if (!has_landed) {
        history.requests = history.all_tiles;
        return false;
    }
    const TimedPass timed(stats, Pass::verify);
    stats.causes =
        reprojection.verify(plan.view, plan.reproject, history.frame_number, history.visibility, history.requests);
    stats.pixels.verified = stats.causes.verified;
    stats.pixels.sky = stats.causes.background;
    stats.triangles_tested = stats.causes.primitives;
    return true;
}

}  // namespace

void draw_reprojected_frame(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
                            FrameStats& stats) {
    if (image.width != plan.view.width || image.height != plan.view.height)
        image.resize(plan.view.width, plan.view.height);
    bool has_landed = false;
    if (plan.may_reproject)
        has_landed = reproject(plan, tools, history, stats);
    else
        history.requests = history.all_tiles;
    {
        const TimedPass timed(stats, Pass::cast);
        const farfield::CastCost cost = farfield::cast_left_over(
            tools.casters.get(CasterKind::embree), tools.casters.get(plan.caster, plan.grid_cells_per_item), plan.view,
            history.requests, history.wanted, history.to_shade, has_landed && plan.reproject.shift_origin,
            history.visibility);
        stats.rays = cost.rays;
        stats.nodes_visited = cost.nodes;
        stats.triangles_tested += cost.triangles;
        stats.pixels.cast_miss = farfield::count_sky(history.requests, history.visibility);
        stats.pixels.cast_hit = cost.rays - stats.pixels.cast_miss;
    }
    if (!plan.dynamic.empty()) {
        const TimedPass timed(stats, Pass::cast);
        tools.dynamic_overlay.draw(plan.view, plan.dynamic, history.all_tiles, history.visibility,
                                   history.sources.dynamic);
        stats.pixels.dynamic = history.sources.dynamic.count();
    }
    const std::uint8_t* const sun_seen =
        find_sun(plan, tools.scene, history.visibility, history.all_tiles, nullptr, history.sun, stats);
    const shading::Reflections* const reflections = find_reflections(plan, tools, history.all_tiles, history, stats);
    const TimedPass timed(stats, Pass::shade);
    stats.shaded_pixels = shading::shade_tiles(
        tools.scene, plan.dynamic, plan.view, history.visibility, history.all_tiles,
        shade_settings(plan, tools, plan.view, sun_seen, history.lights, stats, reflections), image);
}

}  // namespace ff::frame
