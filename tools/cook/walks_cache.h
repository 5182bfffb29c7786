#pragma once
// The spawn point and the standard walks, remembered by the geometry that they were found in.

#include <optional>

#include "tools/cook/cook_cache.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// What a world's geometry, and the spawn point and walks that its author gave, say about its walks. Hashes the meshes.
[[nodiscard]] CacheKey walks_key(WorldSource& world, bool has_spawn);

/// Takes the spawn point and all walks from the cache; false where they are not there.
[[nodiscard]] bool find_walks(const CacheKey& key, CookCache& cache, WorldSource& world);
void store_walks(const CacheKey& key, const WorldSource& world, CookCache& cache);

}  // namespace ff::cook
