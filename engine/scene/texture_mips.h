#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene/static_scene.h"

namespace ff::scene {

/// Appends level 0 and all its mips to `texels` and describes them.
/// @param rgba  width * height texels, RGBA8 sRGB, top row first; sides are powers of two in [1, 8192].
[[nodiscard]] Texture append_mip_chain(std::span<const std::uint32_t> rgba, std::uint32_t width, std::uint32_t height,
                                       std::vector<std::uint32_t>& texels);

/// Linear value of each sRGB byte.
[[nodiscard]] std::span<const float, 256> linear_of_srgb();

}  // namespace ff::scene
