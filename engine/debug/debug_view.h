#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "engine/farfield/reproject.h"
#include "engine/shading/shading_pass.h"

namespace ff::debug {

/// How a pixel came to be.
enum class PixelSource : std::uint8_t {
    near,       ///< a rasterised triangle
    sky,        ///< above the traced horizon
    panorama,   ///< a still-good texel of the panoramic cache
    verified,   ///< a reprojected hit that one intersection confirmed
    cast_hit,   ///< a ray that met something
    cast_miss,  ///< a ray that did not
    stale,      ///< a texel worse than wanted, kept because the ray budget was spent
};
inline constexpr std::size_t kPixelSourceCount = 7;

struct SourceColor {
    PixelSource source;
    std::string_view name;
    std::uint32_t rgba;  ///< sRGB, r in the low byte
};

/// Legend of paint_sources, in the enum's order.
[[nodiscard]] const std::array<SourceColor, kPixelSourceCount>& source_colors();

/// Paints each pixel by its source. Where `shaded` holds a picture of the same size, its brightness shows through.
/// @param sources  [height * stride], rows as in Image::pixels; codes beyond the enum are magenta
void paint_sources(std::span<const PixelSource> sources, int width, int height, int stride, shading::Image& out,
                   const shading::Image* shaded = nullptr);

/// Paints the pixels of a reprojected frame in the colours of P3 Figure 6: red verified by one intersection, green cast
/// because that failed, white resampled, blue abrupt; background, which P3 does not show, is black.
/// @param causes  [height * stride]
void paint_causes(std::span<const farfield::PixelCause> causes, int width, int height, int stride, shading::Image& out);

/// Paints whole tiles of 16 x 16 pixels by the work that they took: blue for none, over green and yellow, to red for
/// the most.
/// @param work  row-major, of the tiles that cover the image
void paint_tile_work(std::span<const std::uint64_t> work, int width, int height, shading::Image& out);

/// Paints ages: new texels blue, over green and yellow, to red at max_age frames and beyond; kNoAge black.
inline constexpr std::uint16_t kNoAge = 0xFFFF;
/// @param ages  frames since the texel was cast, rows of `stride`
void paint_ages(std::span<const std::uint16_t> ages, int width, int height, int stride, std::uint16_t max_age,
                shading::Image& out);

/// Draws a white line one pixel wide along the border of near pixels over a picture of the same size.
void draw_near_border(std::span<const PixelSource> sources, shading::Image& image);

}  // namespace ff::debug
