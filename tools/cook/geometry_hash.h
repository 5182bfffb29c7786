#pragma once
// What steps after the importers depend on: the world's geometry, as hashes. Pixels of textures are no part of it.

#include <string>

#include "tools/cook/world_source.h"

namespace ff::cook {

/// The hash of all meshes and of where they stand. Fills content_hash of the meshes that have none yet; parallel, some
/// GB/s.
[[nodiscard]] std::string hash_geometry(WorldSource& world);

}  // namespace ff::cook
