#include "engine/shading/layer_pass.h"

#include <array>
#include <atomic>
#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/shading/shade_frame.h"
#include "engine/shading/shading_kernel.h"

namespace ff::shading {
namespace {

using farfield::kTileSize;
using farfield::Layer;
using farfield::TileRequest;

/// Layers are few and far between: small tasks, so that workers end together.
constexpr std::size_t kTilesPerTask = 4;
/// What lets less light through is opaque: it could not change a channel by half a level.
constexpr float kOpaque = 1.0f / 512.0f;

/// Whether a layer lies behind another of its pixel. Of two at one depth that with the smaller name is in front, as for
/// opaque surfaces.
bool is_behind(const Layer& a, const Layer& b) {
    if (a.depth != b.depth) return a.depth > b.depth;
    return a.instance != b.instance ? a.instance > b.instance : a.triangle > b.triangle;
}

/// The layers of one tile by pixel, each pixel's from back to front, without those that cannot be seen.
class SortedLayers {
  public:
    /// @param layers  any order; at most kMaxTileLayers
    void sort(std::span<const Layer> layers) {
        end_.fill(0);
        for (const Layer& layer : layers) ++end_[layer.pixel];
        std::uint32_t sum = 0;
        for (std::size_t pixel = 0; pixel < kTilePixels; ++pixel) {
            next_[pixel] = sum;
            sum += end_[pixel];
            end_[pixel] = next_[pixel];
        }
        for (const Layer& layer : layers) {  // insertion: a pixel has few
            std::uint32_t at = end_[layer.pixel]++;
            for (; at > next_[layer.pixel] && is_behind(layer, sorted_[at - 1]); --at) sorted_[at] = sorted_[at - 1];
            sorted_[at] = layer;
        }
        pixel_count_ = 0;
        for (std::size_t pixel = 0; pixel < kTilePixels; ++pixel) {
            float through = 1.0f;
            std::uint32_t shown = end_[pixel];
            while (shown > next_[pixel] && through >= kOpaque) through *= 1.0f - sorted_[--shown].alpha;
            next_[pixel] = shown;
            if (shown != end_[pixel]) pixels_[pixel_count_++] = std::uint8_t(pixel);
        }
    }

    /// Pixels that have layers left.
    [[nodiscard]] std::span<const std::uint8_t> pixels() const { return {pixels_.data(), pixel_count_}; }
    /// The farthest that a pixel has left.
    [[nodiscard]] const Layer& farthest(std::size_t pixel) const { return sorted_[next_[pixel]]; }
    /// Takes the farthest off every pixel.
    void peel() {
        std::size_t kept = 0;
        for (const std::uint8_t pixel : pixels())
            if (++next_[pixel] != end_[pixel]) pixels_[kept++] = pixel;
        pixel_count_ = kept;
    }

  private:
    std::array<std::uint32_t, kTilePixels> next_, end_;  ///< per pixel, into sorted_
    std::array<std::uint8_t, kTilePixels> pixels_;
    std::size_t pixel_count_ = 0;
    std::array<Layer, farfield::kMaxTileLayers> sorted_;
};

/// A layer over a colour, RGBA8.
std::uint32_t blend(std::uint32_t below, std::uint32_t layer, float alpha) {
    const auto weight = std::uint32_t(alpha * 65536.0f + 0.5f);
    std::uint32_t out = 0xFF000000u;
    for (int shift = 0; shift < 24; shift += 8) {
        const std::uint32_t a = layer >> shift & 255u, b = below >> shift & 255u;
        out |= (a * weight + b * (65536u - weight) + 32768u) >> 16 << shift;
    }
    return out;
}

/// One worker's part of the pass.
class TileBlender {
  public:
    TileBlender(const farfield::LayerScene& scene, const farfield::beam::BeamView& view,
                const farfield::VisibilityBuffer& visible, const ShadeFrame& frame, const farfield::SunRays* sun,
                LayerScratch& shared, Image& out)
        : scene_(scene), view_(view), visible_(visible), frame_(frame), sun_(sun), shared_(shared), out_(out) {}

    void run(const TileRequest& tile) {
        const std::size_t count = farfield::find_layers(scene_, view_, tile, visible_, found_);
        if (count == 0) return;
        TileRequest half, rest;
        if (count > found_.size() && split(tile, half, rest)) {
            run(half);
            run(rest);
            return;
        }
        sorted_.sort(std::span<const Layer>(found_).first(std::min(count, found_.size())));
        shade(tile);
    }
    [[nodiscard]] const LayerCounts& counts() const { return counts_; }

  private:
    /// Halves a request; false for a single pixel.
    static bool split(const TileRequest& tile, TileRequest& half, TileRequest& rest) {
        int pixels = 0;
        for (const std::uint16_t row : tile.rows) pixels += std::popcount(row);
        if (pixels < 2) return false;
        half = {tile.x, tile.y, {}};
        rest = tile;
        int moved = 0;
        for (int row = 0; row < kTileSize; ++row)
            for (; moved < pixels / 2 && rest.rows[row] != 0; ++moved) {
                const auto lowest = std::uint16_t(rest.rows[row] & (0u - rest.rows[row]));
                half.rows[row] = std::uint16_t(half.rows[row] | lowest);
                rest.rows[row] = std::uint16_t(rest.rows[row] ^ lowest);
            }
        return true;
    }

    /// Rounds from the back: in each, every pixel with layers left has its farthest one shaded and blended.
    void shade(const TileRequest& tile) {
        const auto index_of = [&](std::uint8_t pixel) {
            return visible_.index(tile.x + pixel % kTileSize, tile.y + pixel / kTileSize);
        };
        for (; !sorted_.pixels().empty(); sorted_.peel()) {
            TileRequest wanted{tile.x, tile.y, {}};
            for (const std::uint8_t pixel : sorted_.pixels()) {
                const Layer& layer = sorted_.farthest(pixel);
                const std::size_t at = index_of(pixel);
                shared_.visibility.instance[at] = layer.instance;
                shared_.visibility.triangle[at] = layer.triangle;
                shared_.visibility.depth[at] = layer.depth;
                std::uint16_t& row = wanted.rows[pixel / kTileSize];
                row = std::uint16_t(row | (1u << pixel % kTileSize));
            }
            if (sun_ != nullptr)
                counts_.sun_rays +=
                    sun_->cast_tiles(frame_.view, shared_.visibility, {&wanted, 1}, shared_.sun_seen.data()).rays;
            counts_.shaded += shade_tile_batch(frame_, {&wanted, 1}, tile_scratch_);
            for (const std::uint8_t pixel : sorted_.pixels()) {
                const std::size_t at = index_of(pixel);
                out_.pixels[at] = blend(out_.pixels[at], shared_.image.pixels[at], sorted_.farthest(pixel).alpha);
            }
        }
    }

    const farfield::LayerScene& scene_;
    const farfield::beam::BeamView& view_;
    const farfield::VisibilityBuffer& visible_;
    const ShadeFrame& frame_;
    const farfield::SunRays* sun_;
    LayerCounts counts_;
    LayerScratch& shared_;
    Image& out_;
    std::array<Layer, farfield::kMaxTileLayers> found_;
    SortedLayers sorted_;
    TileScratch tile_scratch_;
};

}  // namespace

void LayerScratch::fit(const farfield::VisibilityBuffer& view) {
    visibility.width = image.width = view.width;
    visibility.height = image.height = view.height;
    visibility.stride = image.stride = view.stride;
    visibility.rows = view.rows;
    const std::size_t count = std::size_t(view.stride) * std::size_t(view.rows);
    if (image.pixels.size() >= count) return;
    visibility.instance.resize(count);
    visibility.triangle.resize(count);
    visibility.depth.resize(count);
    image.pixels.resize(count);
}

LayerCounts blend_layers(const farfield::LayerScene& scene, const PinholeView& view,
                         const farfield::VisibilityBuffer& visible, std::span<const TileRequest> tiles,
                         const ShadeSettings& settings, const farfield::SunRays* sun, LayerScratch& scratch,
                         Image& out) {
    FF_CHECK(visible.width == view.width && visible.height == view.height, "visibility {}x{} for a view of {}x{}",
             visible.width, visible.height, view.width, view.height);
    FF_CHECK(out.width == view.width && out.height == view.height && out.stride == visible.stride,
             "image {}x{} stride {} for a view of {}x{}, visibility stride {}", out.width, out.height, out.stride,
             view.width, view.height, visible.stride);
    if (!(view.blend_within_m > 0.0f)) return {};
    scratch.fit(visible);
    ShadeSettings layer_settings = settings;
    if (sun != nullptr) {
        if (scratch.sun_seen.size() < visible.depth.size()) scratch.sun_seen.resize(visible.depth.size());
        layer_settings.sun_seen = scratch.sun_seen.data();
    }
    const std::span<const scene::Instance> dynamic =
        scene.dynamic != nullptr ? scene.dynamic->instances : std::span<const scene::Instance>();
    const ShadingUniforms uniforms = make_uniforms(scene.scene.environment, view);
    const ShadeFrame frame{scene.scene,
                           dynamic,
                           view,
                           scratch.visibility,
                           layer_settings,
                           uniforms,
                           make_near_air(uniforms, settings.air_error),
                           scratch.image};
    const farfield::beam::BeamView beam_view(view);
    std::atomic<std::uint64_t> shaded{0}, sun_rays{0};
    parallel_ranges(tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        TileBlender blender(scene, beam_view, visible, frame, sun, scratch, out);
        for (std::size_t i = begin; i < end; ++i) blender.run(tiles[i]);
        shaded.fetch_add(blender.counts().shaded, std::memory_order_relaxed);
        sun_rays.fetch_add(blender.counts().sun_rays, std::memory_order_relaxed);
    });
    return {shaded, sun_rays};
}

}  // namespace ff::shading
