#pragma once
// What steps after the importers depend on: the world's geometry, as hashes. Pixels of textures are no part of it.

#include "tools/cook/cook_cache.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Fills content_hash of the meshes that have none yet. Parallel; about 10 GB/s.
void hash_meshes(WorldSource& world);

/// Adds all meshes and where they stand, in order. The meshes are hashed.
CacheKey& add_geometry(CacheKey& key, const WorldSource& world);

}  // namespace ff::cook
