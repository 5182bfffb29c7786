#pragma once
// Where in the texel array a texture coordinate falls: the one place that knows wraps and mip offsets.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "engine/scene/static_scene.h"

namespace ff::scene {

/// First texel of a mip level, relative to Texture::first_texel. Level < texture.level_count.
[[nodiscard]] inline std::size_t level_offset(const Texture& texture, std::uint32_t level) {
    std::size_t offset = 0;
    for (std::uint32_t l = 0; l < level; ++l)
        offset += std::size_t(std::max(1u, texture.width >> l)) * std::max(1u, texture.height >> l);
    return offset;
}

/// Nearest texel along one side of `size` texels, for any coordinate (a NaN or inf is texel 0).
[[nodiscard]] inline std::uint32_t wrap_texel(float coordinate, std::uint32_t size, Wrap wrap) {
    float c = coordinate;
    if (wrap == Wrap::repeat) {
        c -= std::floor(c);
    } else if (wrap == Wrap::mirror) {
        c -= 2.0f * std::floor(0.5f * c);
        if (c > 1.0f) c = 2.0f - c;
    }
    const float texel = c * float(size);
    return texel > 0.0f ? std::uint32_t(std::min(texel, float(size - 1))) : 0u;
}

/// The two texels around a coordinate along a side of `size` texels, a power of two.
struct TexelPair {
    std::uint32_t first, second;
    float weight;  ///< of the second, [0, 1]
};
/// For any coordinate (what a NaN or inf gives is inside).
[[nodiscard]] inline TexelPair texels_around(float coordinate, std::uint32_t size, Wrap wrap) {
    float c = coordinate;
    if (wrap == Wrap::repeat)
        c -= std::floor(c);
    else if (wrap == Wrap::mirror)
        c -= 2.0f * std::floor(0.5f * c);
    else
        c = c > 0.0f ? std::min(c, 1.0f) : 0.0f;
    if (!(c >= 0.0f)) c = 0.0f;
    const float at = c * float(size) - 0.5f, below = std::floor(at);
    const auto wrapped = [&](std::int32_t i) {
        const auto last = std::int32_t(size) - 1;
        if (wrap == Wrap::repeat) return std::uint32_t(i & last);
        if (wrap == Wrap::clamp) return std::uint32_t(std::clamp(i, 0, last));
        const std::int32_t phase = i & (2 * last + 1);
        return std::uint32_t(std::min(phase, 2 * last + 1 - phase));
    };
    return {wrapped(std::int32_t(below)), wrapped(std::int32_t(below) + 1), at - below};
}

/// Index in StaticScene::texels of the texel nearest to uv on a level.
[[nodiscard]] inline std::size_t texel_index(const Texture& texture, const Vec2& uv, std::uint32_t level) {
    const std::uint32_t width = std::max(1u, texture.width >> level), height = std::max(1u, texture.height >> level);
    return texture.first_texel + level_offset(texture, level) +
           std::size_t(wrap_texel(uv.y, height, texture.wrap_v)) * width + wrap_texel(uv.x, width, texture.wrap_u);
}

}  // namespace ff::scene
