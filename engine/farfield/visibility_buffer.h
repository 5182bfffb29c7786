#pragma once
// The one meeting place of all that finds visibility (design.md section 1): which triangle of which instance each pixel
// sees, and how far. The near rasteriser, reprojection and every ray caster write it; the shading pass reads it once.

#include <cstddef>
#include <cstdint>

#include "engine/core/zero_pages.h"

namespace ff::farfield {

inline constexpr std::uint32_t kSkyInstance = 0xFFFFFFFFu;  ///< the ray leaves the world
inline constexpr std::uint32_t kUnresolved = 0xFFFFFFFEu;   ///< nobody has answered this pixel yet
inline constexpr int kTileSize = 16;                        ///< pixels; tiles start at multiples of it

/// Structure of arrays, row-major from the top left; rows padded to whole tiles, as is the height.
struct VisibilityBuffer {
    int width = 0, height = 0;               ///< pixels
    int stride = 0, rows = 0;                ///< width and height rounded up to tiles
    ZeroPageVector<std::uint32_t> instance;  ///< id in StaticScene::instances; from instance_count on, dynamic ones
    ZeroPageVector<std::uint32_t> triangle;  ///< within the instance's mesh
    ZeroPageVector<float> depth;             ///< along the view axis, metres; +inf for sky

    void resize(int new_width, int new_height);
    [[nodiscard]] std::size_t index(int x, int y) const {
        return std::size_t(y) * std::size_t(stride) + std::size_t(x);
    }
};

/// The pixels of one 16 x 16 tile that somebody still has to answer.
struct TileRequest {
    std::uint16_t x = 0, y = 0;       ///< top left pixel, multiples of 16
    std::uint16_t rows[kTileSize]{};  ///< bit i of rows[j]: pixel (x + i, y + j)

    [[nodiscard]] bool is_empty() const {
        unsigned any = 0;
        for (const std::uint16_t row : rows) any |= row;
        return any == 0;
    }
};

}  // namespace ff::farfield
