#pragma once
// The height grid, remembered by what stands under it.

#include <cstdint>
#include <span>
#include <string>

#include "engine/scene/scene_data.h"
#include "tools/cook/cook_cache.h"

namespace ff::cook {

/// scene::build_height_grid, from the cache where the same scene had one before.
/// @param geometry   hash_geometry of the source: where everything stands
/// @param mesh_keys  of all prepared meshes: the grid is made of their hierarchies
void add_height_grid(std::uint32_t size, const std::string& geometry, std::span<const std::string> mesh_keys,
                     CookCache& cache, scene::SceneData& scene);

}  // namespace ff::cook
