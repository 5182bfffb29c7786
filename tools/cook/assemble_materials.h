#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/scene_data.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Puts the materials in use and their textures, mip-mapped, into `scene`: equal ones once, in the order of the
/// source. Parallel over textures.
/// @param used  [source.materials]
/// @return the new id of each source material; unused ones have 0
[[nodiscard]] std::vector<std::uint16_t> add_materials(const WorldSource& source, const std::vector<bool>& used,
                                                       scene::SceneData& scene);

}  // namespace ff::cook
