#pragma once
// A texture's shape in the low bits of one integer, so that every lane can carry its own.

#include <algorithm>
#include <bit>
#include <cstdint>

#include "engine/scene/static_scene.h"
#include "engine/shading/shading_model.h"

namespace ff::shading {

// Bits 0-3: log2 width; 4-7: log2 height; 8, 9: u clamps, mirrors; 10, 11: v likewise. Free above.
inline constexpr std::int32_t kWrapClamp = 1 << 8;
inline constexpr std::int32_t kWrapMirror = 1 << 9;
inline constexpr int kWrapBits = 2;
inline constexpr std::int32_t kAnyWrapBit = 0xF << 8;

[[nodiscard]] inline std::int32_t texture_info(const scene::Texture& texture) {
    const auto wrap_bits = [](scene::Wrap wrap) {
        return wrap == scene::Wrap::clamp ? kWrapClamp : wrap == scene::Wrap::mirror ? kWrapMirror : 0;
    };
    return std::int32_t(std::bit_width(texture.width) - 1) | std::int32_t(std::bit_width(texture.height) - 1) << 4 |
           wrap_bits(texture.wrap_u) | wrap_bits(texture.wrap_v) << kWrapBits;
}

/// Whether every texel of the scene has an index that 32-bit lanes can hold; else records name the texture instead.
[[nodiscard]] inline bool texel_indices_fit(const scene::StaticScene& scene) {
    return scene.texels.size() < 0x7FFFFFFFu;
}

/// Texels of all levels.
[[nodiscard]] inline std::uint64_t texel_count(const scene::Texture& texture) {
    std::uint64_t count = 0;
    for (std::uint32_t level = 0; level < texture.level_count; ++level)
        count += std::uint64_t(std::max(1u, texture.width >> level)) * std::max(1u, texture.height >> level);
    return count;
}

/// Linear RGB of a texture's last level, its one texel: the mean of all.
[[nodiscard]] inline Vec3 mean_texture_color(const scene::StaticScene& scene, const scene::Texture& texture) {
    const std::uint32_t texel = scene.texels[texture.first_texel + texel_count(texture) - 1];
    Vec3 color;
    for (int k = 0; k < 3; ++k) {
        const float c = float(texel >> 8 * k & 255u) / 255.0f;
        color[k] = c * (kDecode[0] + c * (kDecode[1] + c * (kDecode[2] + c * (kDecode[3] + c * kDecode[4]))));
    }
    return color;
}

}  // namespace ff::shading
