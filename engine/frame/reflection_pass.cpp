#include "engine/frame/reflection_pass.h"

#include <algorithm>
#include <bit>

#include "engine/frame/history.h"
#include "engine/frame/run_passes.h"
#include "engine/frame/shade_settings.h"
#include "engine/frame/timed_pass.h"

namespace ff::frame {
namespace {

using farfield::kTileSize;
using farfield::TileRequest;

constexpr int kCoarsest = 8;  ///< pixels along a side that share a ray at most
/// What a mirror's own surface may stand out of its plane; surfaces within it are not mirrored.
constexpr double kLiftM = 0.03;
/// A finer step is taken once its rays fill no more than this share of the budget: no flicker between two.
constexpr double kRoom = 0.8;

void fit(farfield::VisibilityBuffer& visibility, shading::Image& image, int width, int height) {
    visibility.width = image.width = width;
    visibility.height = image.height = height;
    visibility.stride = image.stride = (width + kTileSize - 1) / kTileSize * kTileSize;
    visibility.rows = (height + kTileSize - 1) / kTileSize * kTileSize;
    std::fill_n(image.pixels.begin(), std::size_t(image.stride) * std::size_t(visibility.rows),
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

/// Finds the mirrors at the finest step that the rays allow.
std::uint64_t find_mirrors(const FramePlan& plan, const effects::MirrorInput& input, ReflectionWork& work) {
    std::uint64_t pixels = work.mirrors.find(input, work.step);
    while (pixels > plan.reflection_rays && work.step < kCoarsest) {
        work.step *= 2;
        pixels = work.mirrors.find(input, work.step);
    }
    return pixels;
}

std::uint64_t cast_mirrors(const FramePlan& plan, ReflectionWork& work) {
    work.requests.clear();
    for (std::size_t i = 0; i < work.mirrors.found().size(); ++i) {
        const farfield::MirrorPlane& plane = work.mirrors.found()[i].plane;
        const PinholeView view = farfield::mirrored_view(plan.view, plane, work.shown.step);
        work.requests.push_back({view, farfield::mirror_before(view, plane, kLiftM), work.mirrors.tiles(i)});
    }
    std::uint64_t rays = work.caster.cast(work.requests, work.visibility).rays;
    if (plan.dynamic.empty()) return rays;
    for (const auto& [view, before, tiles] : work.requests)
        rays += work.moving.draw(view, plan.dynamic, tiles, work.visibility, work.covered, &before).rays;
    return rays;
}

void shade_mirror(const FramePlan& plan, const Tools& tools, const PinholeView& view,
                  std::span<const TileRequest> tiles, FrameHistory& history, ReflectionWork& work, FrameStats& stats) {
    const std::uint8_t* const sun_seen =
        find_sun_in_mirror(plan, tools.scene, view, work.visibility, tiles, work.sun_seen, history.sun, stats);
    shading::ShadeSettings settings = shade_settings(plan, tools, view, sun_seen, history, stats);
    settings.plain_srgb = true;  // what looks it up is shown by film itself
    shading::shade_tiles(tools.scene, plan.dynamic, view, work.visibility, tiles, settings, work.image);
    mark_sky(tiles, work.visibility, work.image);
}

}  // namespace

ReflectionWork::ReflectionWork(const scene::StaticScene& scene, int width, int height)
    : mirrors(width, height), caster(scene), moving(scene), width_(width), height_(height) {
    visibility.resize(width, height);
    image.resize(width, height);
    covered.reset(width, height);
    moving.reserve(width, height);
    requests.reserve(effects::Mirrors::kMost);
    sun_seen = ZeroPageVector<std::uint8_t>(visibility.depth.size());
}

const shading::Reflections* find_reflections(const FramePlan& plan, const Tools& tools, FrameHistory& history,
                                             FrameStats& stats) {
    if (!plan.effects.is_active(effects::EffectId::reflections)) return nullptr;
    const TimedPass timed(stats, Pass::reflect);
    const TimedEffect timed_effect(stats, effects::EffectId::reflections);
    if (!history.reflections)
        history.reflections = std::make_unique<ReflectionWork>(tools.scene, plan.image_width, plan.image_height);
    ReflectionWork& work = *history.reflections;
    const std::uint64_t pixels = find_mirrors(plan,
                                              {.scene = tools.scene,
                                               .dynamic = plan.dynamic,
                                               .view = plan.view,
                                               .visibility = history.visibility,
                                               .within_m = plan.reflections_within_m},
                                              work);
    work.shown.step = work.step;
    work.shown.within_m = plan.reflections_within_m;
    if (4.0 * double(pixels) < kRoom * double(plan.reflection_rays)) work.step = std::max(1, work.step / 2);
    if (work.mirrors.found().empty()) return nullptr;
    const int width = (plan.view.width + work.shown.step - 1) / work.shown.step;
    const int height = (plan.view.height + work.shown.step - 1) / work.shown.step;
    if (width < 2 || height < 2) return nullptr;
    fit(work.visibility, work.image, width, height);
    work.covered.reset(width, height);
    const std::uint64_t rays = cast_mirrors(plan, work);
    stats.rays += rays;
    stats.work(effects::EffectId::reflections).rays += rays;
    for (const farfield::MirrorRequest& mirror : work.requests)
        shade_mirror(plan, tools, mirror.view, mirror.tiles, history, work, stats);
    work.shown.depth = work.visibility.depth.data();
    return &work.shown;
}

}  // namespace ff::frame
