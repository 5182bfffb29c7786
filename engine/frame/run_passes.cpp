#include "engine/frame/run_passes.h"

#include <bit>

#include "engine/core/stopwatch.h"

namespace ff::frame {
namespace {

using farfield::PixelMask;
using farfield::TileRequest;

/// Times a pass from its making to its end.
class TimedPass {
  public:
    TimedPass(FrameStats& stats, Pass pass) : stats_(stats), pass_(pass) {}
    ~TimedPass() { stats_.ms(pass_) += watch_.milliseconds(); }
    TimedPass(const TimedPass&) = delete;
    TimedPass& operator=(const TimedPass&) = delete;

  private:
    FrameStats& stats_;
    Pass pass_;
    Stopwatch watch_;
};

void mark_sky(const PixelMask& sky, farfield::VisibilityBuffer& visibility) {
    for (std::size_t t = 0; t < sky.tiles.size(); ++t) {
        const farfield::TileMask& mask = sky.tiles[t];
        const int x0 = int(t % std::size_t(sky.tiles_x)) * farfield::kTileSize;
        const int y0 = int(t / std::size_t(sky.tiles_x)) * farfield::kTileSize;
        for (int row = 0; row < farfield::kTileSize; ++row) {
            if (mask.rows[row] == 0) continue;
            const std::size_t first = visibility.index(x0, y0 + row);
            for (unsigned i = 0; i < farfield::kTileSize; ++i) {
                if (((mask.rows[row] >> i) & 1u) == 0) continue;
                visibility.instance[first + i] = farfield::kSkyInstance;
                visibility.depth[first + i] = std::numeric_limits<float>::infinity();
            }
        }
    }
}

/// The tiles' pixels that none of the masks has answered; tiles that are done are left out.
std::uint64_t collect_requests(const std::vector<TileRequest>& all, std::span<const PixelMask* const> answered,
                               std::vector<TileRequest>& requests, PixelMask& asked) {
    requests.clear();
    std::uint64_t pixels = 0;
    for (std::size_t t = 0; t < all.size(); ++t) {
        TileRequest request = all[t];
        for (const PixelMask* mask : answered)
            for (int row = 0; row < farfield::kTileSize; ++row)
                request.rows[row] = std::uint16_t(request.rows[row] & ~mask->tiles[t].rows[row]);
        int count = 0;
        for (int row = 0; row < farfield::kTileSize; ++row) {
            asked.tiles[t].rows[row] = request.rows[row];
            count += std::popcount(request.rows[row]);
        }
        if (count > 0) requests.push_back(request);
        pixels += std::uint64_t(count);
    }
    return pixels;
}

std::uint64_t count_misses(std::span<const TileRequest> requests, const farfield::VisibilityBuffer& visibility) {
    std::uint64_t misses = 0;
    for (const TileRequest& request : requests)
        for (int row = 0; row < farfield::kTileSize; ++row) {
            if (request.rows[row] == 0) continue;
            const std::uint32_t* instance = &visibility.instance[visibility.index(request.x, request.y + row)];
            unsigned sky = 0;
            for (unsigned i = 0; i < farfield::kTileSize; ++i)
                sky |= unsigned(instance[i] == farfield::kSkyInstance) << i;
            misses += std::uint64_t(std::popcount(sky & request.rows[row]));
        }
    return misses;
}

}  // namespace

farfield::RayCaster& Casters::get(CasterKind kind) {
    auto& caster = casters_[std::size_t(kind)];
    if (!caster) {
        switch (kind) {
            case CasterKind::beam:
                caster = farfield::make_beam_caster(scene_);
                break;
            case CasterKind::embree:
                caster = farfield::make_embree_caster(scene_);
                break;
            case CasterKind::grid:
                caster = farfield::make_grid_caster(scene_);
                break;
        }
    }
    return *caster;
}

FrameStats run_passes(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image) {
    FrameStats stats;
    const Stopwatch frame_watch;
    farfield::VisibilityBuffer& visibility = history.visibility;
    SourceMasks& sources = history.sources;
    const shading::ShadeSettings shade_settings{.prelit_beyond_m = plan.prelit_beyond_m};
    for (PixelMask* mask : {&sources.near_field, &sources.sky, &sources.panorama, &sources.cast})
        mask->reset(plan.view.width, plan.view.height);

    // Sky: pixels above the skyline.
    if (plan.trace_horizon) {
        const TimedPass timed(stats, Pass::horizon);
        history.horizon.set_quality(0.0f, plan.horizon_subsample);
        history.horizon.update(tools.scene.height_grid, plan.view);
        stats.pixels.sky = farfield::find_sky_pixels(plan.view, history.horizon, sources.sky);
        mark_sky(sources.sky, visibility);
    }

    // Casts: everything that nothing cheaper has answered.
    {
        const TimedPass timed(stats, Pass::cast);
        const PixelMask* const answered[] = {&sources.near_field, &sources.sky, &sources.panorama};
        const std::uint64_t pixels = collect_requests(history.all_tiles, answered, history.requests, sources.cast);
        const farfield::CastCost cost =
            tools.casters.get(plan.caster).cast_tiles(plan.view, history.requests, visibility);
        stats.rays = cost.rays;
        stats.nodes_visited = cost.nodes;
        stats.triangles_tested = cost.triangles;
        stats.pixels.cast_miss = count_misses(history.requests, visibility);
        stats.pixels.cast_hit = pixels - stats.pixels.cast_miss;
    }

    // Shading: each pixel once, whoever found it.
    {
        const TimedPass timed(stats, Pass::shade);
        stats.shaded_pixels = shading::shade_tiles(tools.scene, plan.dynamic, plan.view, visibility, history.all_tiles,
                                                   shade_settings, image);
    }

    stats.near_m = plan.near_m;
    stats.ray_budget = plan.ray_budget;
    stats.frame_ms = frame_watch.milliseconds();
    return stats;
}

}  // namespace ff::frame
