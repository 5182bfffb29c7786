#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/scene_data.h"

namespace ff::scene {

/// Mean base colour of every triangle of the scene, linear RGBA8: factor, vertex colours, and the texture at the mip
/// whose texels are about as large as the triangle.
/// Source: P1 4.6 (one colour per triangle beyond a distance).
[[nodiscard]] std::vector<std::uint32_t> make_prelit_colors(const SceneData& scene);

}  // namespace ff::scene
