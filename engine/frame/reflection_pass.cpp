#include "engine/frame/reflection_pass.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include "engine/core/jobs.h"
#include "engine/frame/history.h"
#include "engine/frame/run_passes.h"
#include "engine/frame/shade_settings.h"
#include "engine/frame/timed_pass.h"

namespace ff::frame {
namespace {

using farfield::kTileSize;
using farfield::TileRequest;

constexpr std::size_t kMostLamps = 4096;  ///< near a mirror that memory is taken for beforehand
constexpr int kCoarsest = 8;              ///< pixels along a side that share a ray at most
/// What a mirror's own surface may stand out of its plane; surfaces within it are not mirrored.
constexpr double kLiftM = 0.03;
/// A finer step is taken once its rays fill no more than this share of the budget: no flicker between two.
constexpr double kRoom = 0.8;

/// Texels are shaded once for many frames: so many times a frame's rays may go into those of one.
constexpr std::uint64_t kPanoramaRays = 4;

/// Pixels of a visibility buffer.
struct Rectangle {
    int left, top, width, height;
};

/// Nothing in a face of the panorama is farther away than so many times its depth: it has waves by the distance.
constexpr float kDepthDistance = 1.7321f;

/// Around tiles, of which there is at least one.
Rectangle bounds_of(std::span<const TileRequest> tiles) {
    int left = tiles[0].x, top = tiles[0].y, right = left, bottom = top;
    for (const TileRequest& tile : tiles) {
        left = std::min(left, int(tile.x));
        top = std::min(top, int(tile.y));
        right = std::max(right, int(tile.x));
        bottom = std::max(bottom, int(tile.y));
    }
    return {left, top, right + kTileSize - left, bottom + kTileSize - top};
}

/// A part of a view as a view of its own.
PinholeView window(const PinholeView& view, const Rectangle& part) {
    PinholeView shown = view;
    shown.width = part.width;
    shown.height = part.height;
    shown.u_first += float(part.left) * view.u_step;
    shown.v_first += float(part.top) * view.v_step;
    return shown;
}

/// Makes room for an image in which nobody has asked for anything yet; where nobody looks it is left as it was.
void fit(farfield::VisibilityBuffer& visibility, shading::Image& image, int width, int height,
         std::span<const TileRequest> looked_at) {
    visibility.width = image.width = width;
    visibility.height = image.height = height;
    visibility.stride = image.stride = (width + kTileSize - 1) / kTileSize * kTileSize;
    visibility.rows = (height + kTileSize - 1) / kTileSize * kTileSize;
    for (const TileRequest& tile : looked_at)
        for (int row = 0; row < kTileSize; ++row)
            std::fill_n(image.pixels.begin() + std::ptrdiff_t(visibility.index(tile.x, tile.y + row)), kTileSize,
                        shading::kReflectsUnknown);
}

/// Tells pixels that left the world from surfaces, where shading has made all opaque.
void mark_sky(std::span<const TileRequest> tiles, const farfield::VisibilityBuffer& visibility, shading::Image& image) {
    for (const TileRequest& tile : tiles)
        for (int row = 0; row < kTileSize; ++row)
            for (unsigned left = tile.rows[row]; left != 0; left &= left - 1) {
                const std::size_t at = visibility.index(tile.x + std::countr_zero(left), tile.y + row);
                if (visibility.instance[at] == farfield::kSkyInstance)
                    image.pixels[at] = (image.pixels[at] & 0xFFFFFFu) | shading::kReflectsSky << 24;
            }
}

/// Where few pixels ask, their reflections are no finer than those of a whole frame: a quarter of its rays at least, as
/// they may all be mirrors.
std::uint64_t rays_for(const FramePlan& plan, std::span<const TileRequest> tiles) {
    constexpr std::uint64_t kLeastShare = 4;
    std::uint64_t asked = 0;
    for (const TileRequest& tile : tiles)
        for (const std::uint16_t row : tile.rows) asked += std::uint64_t(std::popcount(row));
    const auto all = std::uint64_t(plan.view.width) * std::uint64_t(plan.view.height);
    return std::max(plan.reflection_rays * asked / all, plan.reflection_rays / kLeastShare);
}

/// Finds the mirrors at the finest step that the rays allow.
std::uint64_t find_mirrors(const effects::MirrorInput& input, std::uint64_t rays, ReflectionWork& work) {
    std::uint64_t pixels = work.mirrors.find(input, work.step);
    while (pixels > rays && work.step < kCoarsest) {
        work.step *= 2;
        pixels = work.mirrors.find(input, work.step);
    }
    return pixels;
}

std::uint64_t cast_mirrors(const effects::MirrorInput& input, ReflectionWork& work) {
    work.requests.clear();
    for (std::size_t i = 0; i < work.mirrors.found().size(); ++i) {
        const farfield::MirrorPlane& plane = work.mirrors.found()[i].plane;
        const PinholeView view = farfield::mirrored_view(input.view, plane, work.shown.step);
        work.requests.push_back({view, farfield::mirror_before(view, plane, kLiftM), work.mirrors.tiles(i)});
    }
    std::uint64_t rays = work.caster.cast(work.requests, work.visibility).rays;
    if (input.dynamic.empty()) return rays;
    for (const auto& [view, before, tiles] : work.requests)
        rays += work.moving.draw(view, input.dynamic, tiles, work.visibility, work.covered, &before).rays;
    return rays;
}

/// Mirrors side by side: most have but a few tiles, whose pixels no other mirror has.
void shade_mirrors(const FramePlan& plan, const Tools& tools, std::span<const scene::Instance> dynamic,
                   FrameHistory& history, ReflectionWork& work, FrameStats& stats) {
    const farfield::SunRays* const sun = begin_sun_rays(plan, tools.scene, dynamic, history.sun);
    std::uint8_t* const sun_seen = work.sun_seen.data();
    for (std::size_t i = 0; i < work.requests.size(); ++i) {
        auto& [lights, settings] = work.looks[i];
        settings = shade_settings(plan, tools, work.requests[i].view, sun ? sun_seen : nullptr, lights, stats);
        settings.plain_srgb = true;  // what looks it up is shown by film itself
    }
    if (sun != nullptr) {
        std::atomic<std::uint64_t> rays{0};
        parallel_for(work.requests.size(), [&](std::size_t i) {
            rays += sun->cast_tiles(work.requests[i].view, work.visibility, work.requests[i].tiles, sun_seen).rays;
        });
        count_sun_rays(rays, stats);
    }
    parallel_for(work.requests.size(), [&](std::size_t i) {
        const auto& [view, before, tiles] = work.requests[i];
        shading::shade_tiles(tools.scene, dynamic, view, work.visibility, tiles, work.looks[i].settings, work.image);
        mark_sky(tiles, work.visibility, work.image);
    });
}

/// Casts and shades what the mirrors of a view show.
/// @return nullptr where there are none
const shading::Reflections* show(const FramePlan& plan, const Tools& tools, const effects::MirrorInput& input,
                                 FrameHistory& history, ReflectionWork& work, FrameStats& stats) {
    work.shown.step = work.step;
    work.shown.left = input.left;
    work.shown.top = input.top;
    work.shown.within_m = plan.reflections_within_m;
    if (work.mirrors.found().empty()) return nullptr;
    const int width = (input.view.width + work.step - 1) / work.step;
    const int height = (input.view.height + work.step - 1) / work.step;
    if (width < 2 || height < 2) return nullptr;
    fit(work.visibility, work.image, width, height, work.mirrors.looked_at());
    work.covered.reset(width, height);
    const std::uint64_t rays = cast_mirrors(input, work);
    stats.rays += rays;
    stats.work(effects::EffectId::reflections).rays += rays;
    shade_mirrors(plan, tools, input.dynamic, history, work, stats);
    work.shown.depth = work.visibility.depth.data();
    return &work.shown;
}

}  // namespace

ReflectionWork::ReflectionWork(const scene::StaticScene& scene, int width, int height, int least_step)
    : mirrors(width, height, least_step),
      caster(scene),
      moving(scene),
      step(std::max(least_step, kFirstStep)),
      width_(width),
      height_(height) {
    const int most_x = (width + least_step - 1) / least_step, most_y = (height + least_step - 1) / least_step;
    visibility.resize(most_x, most_y);
    image.resize(most_x, most_y);
    covered.reset(most_x, most_y);
    moving.reserve(most_x, most_y);
    requests.reserve(effects::Mirrors::kMost);
    looks.resize(effects::Mirrors::kMost);
    for (Look& look : looks) look.lights.lamps.reserve(std::min(scene.lamps.size(), kMostLamps));
    caster.reserve(effects::Mirrors::kMost, most_x, most_y);
    sun_seen = ZeroPageVector<std::uint8_t>(visibility.depth.size());
}

const shading::Reflections* find_reflections(const FramePlan& plan, const Tools& tools,
                                             std::span<const TileRequest> tiles, FrameHistory& history,
                                             FrameStats& stats) {
    if (!plan.effects.is_active(effects::EffectId::reflections)) return nullptr;
    const TimedPass timed(stats, Pass::reflect);
    const TimedEffect timed_effect(stats, effects::EffectId::reflections);
    if (!history.reflections)
        history.reflections = std::make_unique<ReflectionWork>(tools.scene, plan.image_width, plan.image_height, 1);
    ReflectionWork& work = *history.reflections;
    const effects::MirrorInput input{.scene = tools.scene,
                                     .dynamic = plan.dynamic,
                                     .view = plan.view,
                                     .visibility = history.visibility,
                                     .tiles = tiles,
                                     .within_m = plan.reflections_within_m};
    const std::uint64_t rays = rays_for(plan, tiles);
    const std::uint64_t pixels = find_mirrors(input, rays, work);
    const shading::Reflections* const shown = show(plan, tools, input, history, work, stats);
    if (4.0 * double(pixels) < kRoom * double(rays)) work.step = std::max(1, work.step / 2);
    return shown;
}

const shading::Reflections* find_reflections_of_panorama(const FramePlan& plan, const Tools& tools,
                                                         const PinholeView& view, std::span<const TileRequest> texels,
                                                         FrameHistory& history, FrameStats& stats) {
    if (!plan.effects.is_active(effects::EffectId::reflections) || texels.empty()) return nullptr;
    const TimedPass timed(stats, Pass::reflect);
    const TimedEffect timed_effect(stats, effects::EffectId::reflections);
    std::unique_ptr<ReflectionWork>& made = history.panorama_reflections;
    // A face is as wide as it is high; the view has all six.
    if (!made) made = std::make_unique<ReflectionWork>(tools.scene, view.width, view.width, ReflectionWork::kFirstStep);
    ReflectionWork& work = *made;
    work.step = ReflectionWork::kFirstStep;
    const Rectangle part = bounds_of(texels);
    const PinholeView shown = window(view, part);
    const effects::MirrorInput input{.scene = tools.scene,
                                     .dynamic = {},
                                     .view = shown,
                                     .visibility = history.panorama->map(),
                                     .left = part.left,
                                     .top = part.top,
                                     .tiles = texels,
                                     .within_m = plan.reflections_within_m,
                                     .water_beyond_m = plan.water_within_m / kDepthDistance};
    find_mirrors(input, kPanoramaRays * plan.reflection_rays, work);
    return show(plan, tools, input, history, work, stats);
}

}  // namespace ff::frame
