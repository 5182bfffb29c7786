#include "engine/debug/debug_view.h"

#include <algorithm>

#include "engine/core/check.h"

namespace ff::debug {
namespace {

constexpr std::uint32_t rgb(std::uint32_t r, std::uint32_t g, std::uint32_t b) {
    return r | g << 8 | b << 16 | 0xFF000000u;
}
constexpr std::uint32_t kUnknown = rgb(255, 0, 255);

/// In the order of the enum. Apart in brightness too, for eyes and printers that lose hues.
constexpr std::array<SourceColor, kPixelSourceCount> kColors{{
    {PixelSource::near, "near field", rgb(230, 159, 0)},
    {PixelSource::sky, "sky by the horizon", rgb(86, 180, 233)},
    {PixelSource::panorama, "panorama", rgb(0, 158, 115)},
    {PixelSource::verified, "verified", rgb(180, 220, 120)},
    {PixelSource::cast_hit, "cast, hit", rgb(213, 94, 0)},
    {PixelSource::cast_miss, "cast, missed", rgb(240, 228, 66)},
    {PixelSource::stale, "stale", rgb(110, 40, 110)},
}};

std::uint32_t channel(std::uint32_t rgba, int shift) {
    return rgba >> shift & 255u;
}

/// A colour at half strength on the brightness of a shaded pixel.
std::uint32_t tinted(std::uint32_t color, std::uint32_t shaded) {
    const std::uint32_t grey = (2 * channel(shaded, 0) + 5 * channel(shaded, 8) + channel(shaded, 16)) / 8;
    const auto mixed = [&](int shift) { return (channel(color, shift) * (96 + grey)) / 351; };
    return rgb(mixed(0), mixed(8), mixed(16));
}

/// Blue, green, yellow, red at 0, 1/3, 2/3, 1.
std::uint32_t ramp(float share) {
    const float t = std::min(share, 1.0f) * 3.0f;
    const auto level = [](float v) { return std::uint32_t(255.0f * std::clamp(v, 0.0f, 1.0f)); };
    return rgb(level(t - 1.0f), level(t < 2.0f ? t : 3.0f - t), level(1.0f - t));
}

void fit(shading::Image& image, int width, int height) {
    if (image.width != width || image.height != height) image.resize(width, height);
}

}  // namespace

const std::array<SourceColor, kPixelSourceCount>& source_colors() {
    return kColors;
}

void paint_sources(std::span<const PixelSource> sources, int width, int height, int stride, shading::Image& out,
                   const shading::Image* shaded) {
    FF_CHECK(sources.size() >= std::size_t(stride) * std::size_t(height), "{} codes for {} rows of {}", sources.size(),
             height, stride);
    fit(out, width, height);
    const bool tint = shaded && shaded->width == width && shaded->height == height;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto source = std::size_t(sources[std::size_t(y) * std::size_t(stride) + std::size_t(x)]);
            std::uint32_t color = source < kPixelSourceCount ? kColors[source].rgba : kUnknown;
            if (tint)
                color = tinted(color, shaded->pixels[std::size_t(y) * std::size_t(shaded->stride) + std::size_t(x)]);
            out.pixels[std::size_t(y) * std::size_t(out.stride) + std::size_t(x)] = color;
        }
    }
}

void paint_causes(std::span<const farfield::PixelCause> causes, int width, int height, int stride,
                  shading::Image& out) {
    FF_CHECK(causes.size() >= std::size_t(stride) * std::size_t(height), "{} codes for {} rows of {}", causes.size(),
             height, stride);
    fit(out, width, height);
    const auto color_of = [](farfield::PixelCause cause) {
        switch (cause) {
            case farfield::PixelCause::verified:
                return rgb(220, 30, 30);
            case farfield::PixelCause::background:
                return rgb(0, 0, 0);
            case farfield::PixelCause::failed:
                return rgb(0, 200, 0);
            case farfield::PixelCause::resampled:
                return rgb(255, 255, 255);
            case farfield::PixelCause::abrupt:
                return rgb(40, 80, 255);
        }
        return kUnknown;
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            out.pixels[std::size_t(y) * std::size_t(out.stride) + std::size_t(x)] =
                color_of(causes[std::size_t(y) * std::size_t(stride) + std::size_t(x)]);
}

void paint_tile_work(std::span<const std::uint64_t> work, int width, int height, shading::Image& out) {
    constexpr int kTile = farfield::kTileSize;
    const int tiles_x = (width + kTile - 1) / kTile, tiles_y = (height + kTile - 1) / kTile;
    FF_CHECK(work.size() >= std::size_t(tiles_x) * std::size_t(tiles_y), "{} tiles for {} x {}", work.size(), tiles_x,
             tiles_y);
    fit(out, width, height);
    const std::uint64_t most =
        std::max<std::uint64_t>(1, work.empty() ? 1 : *std::max_element(work.begin(), work.end()));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::uint64_t own = work[std::size_t(y / kTile) * std::size_t(tiles_x) + std::size_t(x / kTile)];
            out.pixels[std::size_t(y) * std::size_t(out.stride) + std::size_t(x)] = ramp(float(own) / float(most));
        }
}

void paint_ages(std::span<const std::uint16_t> ages, int width, int height, int stride, std::uint16_t max_age,
                shading::Image& out) {
    FF_CHECK(ages.size() >= std::size_t(stride) * std::size_t(height), "{} ages for {} rows of {}", ages.size(), height,
             stride);
    fit(out, width, height);
    const auto color_of = [&](std::uint16_t age) {
        if (age == kNoAge) return rgb(0, 0, 0);
        return ramp(float(age) / float(std::max<std::uint16_t>(max_age, 1)));
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            out.pixels[std::size_t(y) * std::size_t(out.stride) + std::size_t(x)] =
                color_of(ages[std::size_t(y) * std::size_t(stride) + std::size_t(x)]);
}

void draw_near_border(std::span<const PixelSource> sources, shading::Image& image) {
    const auto stride = std::size_t(image.stride);
    FF_CHECK(sources.size() >= stride * std::size_t(image.height), "{} codes for {} rows of {}", sources.size(),
             image.height, image.stride);
    const auto is_near = [&](int x, int y) {
        return sources[std::size_t(y) * stride + std::size_t(x)] == PixelSource::near;
    };
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            if (!is_near(x, y)) continue;
            const bool edge = (x > 0 && !is_near(x - 1, y)) || (x + 1 < image.width && !is_near(x + 1, y)) ||
                              (y > 0 && !is_near(x, y - 1)) || (y + 1 < image.height && !is_near(x, y + 1));
            if (edge) image.pixels[std::size_t(y) * stride + std::size_t(x)] = 0xFFFFFFFFu;
        }
    }
}

}  // namespace ff::debug
