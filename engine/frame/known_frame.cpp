#include "engine/frame/known_frame.h"

#include "engine/core/stopwatch.h"
#include "engine/farfield/known_pixels.h"
#include "engine/frame/timed_pass.h"

namespace ff::frame {

void confirm_known_primitives(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats) {
    farfield::VisibilityBuffer& visibility = history.visibility;
    {
        const Stopwatch watch;
        tools.casters.get(plan.caster, plan.grid_cells_per_item).cast_tiles(plan.view, history.all_tiles, visibility);
        stats.untimed_ms = watch.milliseconds();
    }
    const TimedPass timed(stats, Pass::verify);
    const farfield::CastCost cost = farfield::cast_known_pixels(tools.scene, plan.view, history.all_tiles, visibility);
    stats.pixels.verified = stats.rays = cost.rays;
    stats.triangles_tested = cost.triangles;
    stats.pixels.sky = std::uint64_t(plan.view.width) * std::uint64_t(plan.view.height) - stats.pixels.verified;
}

}  // namespace ff::frame
