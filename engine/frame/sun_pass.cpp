#include "engine/frame/sun_pass.h"

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>
#include <iterator>

#include "engine/core/jobs.h"
#include "engine/frame/timed_pass.h"

namespace ff::frame {
namespace {

/// Reuse pays while it leaves no more than this share of the pixels: strewn rays cost several times what those of whole
/// tiles do. Where it leaves more it is tried again after a while.
constexpr double kMostLeft = 0.45;
constexpr int kPauseFrames = 24;

std::uint64_t count_pixels(std::span<const farfield::TileRequest> tiles) {
    std::uint64_t count = 0;
    for (const farfield::TileRequest& tile : tiles)
        for (const std::uint16_t row : tile.rows) count += std::uint64_t(std::popcount(row));
    return count;
}

SunLight& made(const scene::StaticScene& scene, std::unique_ptr<SunLight>& sun) {
    if (!sun) sun = std::make_unique<SunLight>(scene);
    return *sun;
}

/// Room for a byte a pixel, never less than before.
std::uint8_t* fit(const farfield::VisibilityBuffer& visibility, ZeroPageVector<std::uint8_t>& plane) {
    const std::size_t count = std::size_t(visibility.stride) * std::size_t(visibility.rows);
    if (plane.size() < count) plane = ZeroPageVector<std::uint8_t>(count);
    return plane.data();
}

/// What texels know of the pixels' light, but where the shadow of something that moves may fall. The rest is left in
/// light.cast.
/// @return pixels answered
std::uint64_t ask_panorama(const farfield::SunHistoryInput& input, farfield::Panorama& panorama, SunLight& light,
                           std::uint8_t* seen) {
    light.shadows.begin(input.view, input.moving, input.to_sun);
    light.cast.assign(input.tiles.begin(), input.tiles.end());
    light.shaded.assign(input.tiles.begin(), input.tiles.end());
    constexpr std::size_t kTilesPerTask = 64;
    parallel_ranges(input.tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            if (!light.shadows.find(input.visibility, light.shaded[t])) continue;
            for (int row = 0; row < farfield::kTileSize; ++row)
                light.cast[t].rows[row] &= std::uint16_t(~light.shaded[t].rows[row]);
        }
    });
    const std::uint64_t answered = panorama.known_light(input.visibility, seen, light.cast);
    std::copy_if(light.shaded.begin(), light.shaded.end(), std::back_inserter(light.cast),
                 [](const farfield::TileRequest& tile) { return !tile.is_empty(); });
    return answered;
}

}  // namespace

void count_sun_rays(std::uint64_t rays, FrameStats& stats) {
    stats.sun_rays += rays;
    stats.work(effects::EffectId::sun_shadows).rays += rays;
}

void bound_moving(std::span<const scene::Instance> dynamic, std::vector<farfield::MovingSphere>& out) {
    out.clear();
    for (const scene::Instance& instance : dynamic)
        if (!instance.bounds.is_empty())
            out.push_back({(instance.bounds.low + instance.bounds.high) * 0.5,
                           glm::length(instance.bounds.high - instance.bounds.low) * 0.5, instance.bounds});
}

const std::uint8_t* find_sun(const FramePlan& plan, const scene::StaticScene& scene,
                             const farfield::VisibilityBuffer& visibility, std::span<const farfield::TileRequest> tiles,
                             farfield::Panorama* panorama, std::unique_ptr<SunLight>& sun, FrameStats& stats) {
    if (!plan.sun_shadows) return nullptr;
    const TimedPass timed(stats, Pass::sun);
    const TimedEffect timed_effect(stats, effects::EffectId::sun_shadows);
    SunLight& light = made(scene, sun);
    std::uint8_t* const seen = fit(visibility, light.seen);
    const Vec3 to_sun = scene.environment.to_sun;
    std::span<const farfield::TileRequest> cast = tiles;
    bound_moving(plan.dynamic, light.moving);
    const farfield::SunHistoryInput input{.view = plan.view,
                                          .visibility = visibility,
                                          .tiles = tiles,
                                          .static_instances = std::uint32_t(scene.instances.size()),
                                          .moving = light.moving,
                                          .to_sun = to_sun,
                                          .refresh_frames = plan.sun_refresh_frames};
    const bool asks_panorama = plan.reuse_sun && panorama != nullptr;
    // Where texels answer most pixels the last frame's light has holes everywhere.
    const bool reuse = plan.reuse_sun && !asks_panorama && light.pause_frames == 0;
    if (asks_panorama) stats.sun_reused += ask_panorama(input, *panorama, light, seen);
    if (asks_panorama) cast = light.cast;
    if (!reuse) {
        light.history.clear();
        light.pause_frames = std::max(0, light.pause_frames - 1);
    } else {
        const bool knew = light.history.knows();
        const std::uint64_t reused = light.history.reuse(input, seen, light.cast);
        stats.sun_reused += reused;
        cast = light.cast;
        if (knew && double(count_pixels(cast)) > kMostLeft * double(reused + count_pixels(cast)))
            light.pause_frames = kPauseFrames;
    }
    count_sun_rays(light.rays.cast(plan.view, visibility, cast, plan.dynamic, to_sun, seen).rays, stats);
    if (reuse) light.history.commit(input, cast, seen);
    return seen;
}

const std::uint8_t* find_sun_of_panorama(const FramePlan& plan, const scene::StaticScene& scene,
                                         const PinholeView& view, std::span<const farfield::TileRequest> texels,
                                         farfield::Panorama& panorama, std::unique_ptr<SunLight>& sun,
                                         FrameStats& stats) {
    if (!plan.sun_shadows) return nullptr;
    const TimedPass timed(stats, Pass::sun);
    const TimedEffect timed_effect(stats, effects::EffectId::sun_shadows);
    SunLight& light = made(scene, sun);
    std::uint8_t* const seen = panorama.light();
    count_sun_rays(light.rays.cast(view, panorama.map(), texels, {}, scene.environment.to_sun, seen).rays, stats);
    return seen;
}

const farfield::SunRays* begin_sun_rays(const FramePlan& plan, const scene::StaticScene& scene,
                                        std::span<const scene::Instance> dynamic, std::unique_ptr<SunLight>& sun) {
    if (!plan.sun_shadows) return nullptr;
    SunLight& light = made(scene, sun);
    light.rays.begin_tiles(dynamic, plan.environment.to_sun);
    return &light.rays;
}

}  // namespace ff::frame
