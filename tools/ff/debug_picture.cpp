#include "tools/ff/debug_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/debug/debug_view.h"

namespace ff::tool {
namespace {

using debug::PixelSource;

/// The pixel that a pixel of the image was drawn as: the frame may have been drawn smaller.
std::pair<int, int> drawn_pixel(const frame::FrameHistory& history, const shading::Image& image, int x, int y) {
    return {x * history.visibility.width / image.width, y * history.visibility.height / image.height};
}

/// Codes in the image's own layout.
/// Causes of the last frame's pixels; null where nothing was reprojected.
const farfield::Reprojection::Causes* last_causes(const frame::FrameHistory& history) {
    const farfield::ReprojectCounts& counts = history.last_stats.causes;
    const std::uint64_t pixels = counts.verified + counts.background + counts.failed + counts.resampled + counts.abrupt;
    return pixels > 0 ? &history.reprojection->causes() : nullptr;
}

std::vector<PixelSource> pixel_sources(const frame::FrameHistory& history, const shading::Image& image) {
    std::vector<PixelSource> codes(image.pixels.size(), PixelSource::cast_hit);
    const frame::SourceMasks& masks = history.sources;
    const auto* causes = last_causes(history);
    for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < image.width; ++column) {
            PixelSource& code = codes[std::size_t(row) * std::size_t(image.stride) + std::size_t(column)];
            const auto [x, y] = drawn_pixel(history, image, column, row);
            if (masks.near_field.test(x, y))
                code = PixelSource::near;
            else if (masks.sky.test(x, y))
                code = PixelSource::sky;
            else if (masks.panorama.test(x, y))
                code = PixelSource::panorama;
            else if (causes != nullptr && causes->at(x, y) == farfield::PixelCause::verified)
                code = PixelSource::verified;
            else if (history.visibility.instance[history.visibility.index(x, y)] == farfield::kSkyInstance)
                code = PixelSource::cast_miss;
        }
    return codes;
}

void paint_texel_ages(const frame::Renderer& renderer, shading::Image& image) {
    constexpr std::uint16_t kOldFrames = 120;
    const frame::FrameHistory& history = renderer.history();
    std::vector<std::uint16_t> ages(image.pixels.size(), debug::kNoAge);
    for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < image.width; ++column) {
            const auto [x, y] = drawn_pixel(history, image, column, row);
            if (!history.panorama || !history.sources.panorama.test(x, y)) continue;
            const std::int64_t age = history.panorama->age(renderer.plan().view.direction(x, y));
            if (age < 0) continue;
            ages[std::size_t(row) * std::size_t(image.stride) + std::size_t(column)] =
                std::uint16_t(std::min<std::int64_t>(age, debug::kNoAge - 1));
        }
    debug::paint_ages(ages, image.width, image.height, image.stride, kOldFrames, image);
}

void paint_light_ages(const frame::Renderer& renderer, shading::Image& image) {
    constexpr std::uint16_t kOldFrames = 32;
    const frame::FrameHistory& history = renderer.history();
    std::vector<std::uint16_t> ages(image.pixels.size(), debug::kNoAge);
    for (int row = 0; row < image.height && history.sun; ++row)
        for (int column = 0; column < image.width; ++column) {
            const auto [x, y] = drawn_pixel(history, image, column, row);
            const int age = history.sun->history.age(x, y);
            if (age >= 0) ages[std::size_t(row) * std::size_t(image.stride) + std::size_t(column)] = std::uint16_t(age);
        }
    debug::paint_ages(ages, image.width, image.height, image.stride, kOldFrames, image);
}

void paint_causes(const frame::Renderer& renderer, shading::Image& image) {
    const frame::FrameHistory& history = renderer.history();
    std::vector<farfield::PixelCause> causes(image.pixels.size(), farfield::PixelCause::failed);
    if (const auto* last = last_causes(history))
        for (int row = 0; row < image.height; ++row)
            for (int column = 0; column < image.width; ++column) {
                const auto [x, y] = drawn_pixel(history, image, column, row);
                causes[std::size_t(row) * std::size_t(image.stride) + std::size_t(column)] = last->at(x, y);
            }
    debug::paint_causes(causes, image.width, image.height, image.stride, image);
}

/// Casts the view once more, a tile at a time.
void paint_beam_work(const frame::Renderer& renderer, frame::Casters& casters, shading::Image& image) {
    const PinholeView& view = renderer.plan().view;
    farfield::RayCaster& caster = casters.get(frame::CasterKind::beam);
    farfield::VisibilityBuffer visibility;
    visibility.resize(view.width, view.height);
    std::vector<std::uint64_t> work;
    for (const farfield::TileRequest& tile : renderer.history().all_tiles) {
        const farfield::CastCost cost = caster.cast_tiles(view, std::span(&tile, 1), visibility);
        work.push_back(cost.nodes + cost.triangles);
    }
    debug::paint_tile_work(work, view.width, view.height, image);
}

}  // namespace

void draw_debug_view(DebugView view, const frame::Renderer& renderer, frame::Casters& casters, shading::Image& image) {
    switch (view) {
        case DebugView::none:
            return;
        case DebugView::sources: {
            const shading::Image shaded = image;
            debug::paint_sources(pixel_sources(renderer.history(), image), image.width, image.height, image.stride,
                                 image, &shaded);
            return;
        }
        case DebugView::age:
            return paint_texel_ages(renderer, image);
        case DebugView::light:
            return paint_light_ages(renderer, image);
        case DebugView::causes:
            return paint_causes(renderer, image);
        case DebugView::work:
            return paint_beam_work(renderer, casters, image);
        case DebugView::border:
            return debug::draw_near_border(pixel_sources(renderer.history(), image), image);
    }
}

void fill_overlay(const frame::Renderer& renderer, debug::OverlayData& data) {
    const frame::FrameStats& stats = renderer.history().last_stats;
    data.title = fmt::format("{:.2f} ms", stats.frame_ms);
    data.rows.clear();
    for (std::size_t p = 0; p < frame::kPassCount; ++p)
        if (stats.pass_ms[p] > 0.0)
            data.rows.push_back({std::string(frame::kPassNames[p]), fmt::format("{:.2f} ms", stats.pass_ms[p])});
    const auto all = double(renderer.plan().view.width) * renderer.plan().view.height;
    const auto percent = [&](std::uint64_t pixels) { return fmt::format("{:.1f} %", 100.0 * double(pixels) / all); };
    if (stats.resolution < 1.0)
        data.rows.push_back({"drawn at", fmt::format("{:.0f} % of each side", 100.0 * stats.resolution)});
    data.rows.push_back({"near pixels", percent(stats.pixels.near_field)});
    data.rows.push_back({"sky pixels", percent(stats.pixels.sky)});
    data.rows.push_back({"panorama pixels", percent(stats.pixels.panorama)});
    data.rows.push_back({"stale of these", percent(stats.pixels.stale)});
    data.rows.push_back({"cast, hit", percent(stats.pixels.cast_hit)});
    data.rows.push_back({"cast, missed", percent(stats.pixels.cast_miss)});
    data.rows.push_back({"rays", fmt::format("{}", stats.rays)});
    data.rows.push_back({"near distance", std::isfinite(stats.near_m) ? fmt::format("{:.0f} m", stats.near_m) : "all"});
    data.rows.push_back({"near triangles", fmt::format("{}", stats.near_triangles)});
    data.rows.push_back(
        {"parallax p99, max", fmt::format("{:.2f}, {:.2f} px", stats.parallax_p99_px, stats.parallax_max_px)});
    for (const effects::Effect& effect : effects::registry()) {
        const auto& [state, reason] = stats.effects[effect.id];
        data.rows.push_back(
            {std::string(effect.name), fmt::format("{}: {}", effects::kStateNames[std::size_t(state)], reason)});
    }
}

}  // namespace ff::tool
