#pragma once
// Terrain's dear steps, remembered by all that they depend on.

#include "tools/cook/cook_cache.h"
#include "tools/cook/terrain.h"
#include "tools/cook/terrain_valley.h"

namespace ff::cook {

/// make_valley, from the cache where it has been made before.
[[nodiscard]] HeightField make_valley_cached(const ValleySettings& settings, CookCache& cache);

/// A terrain, its error pyramid from the cache where the same field has been seen before.
[[nodiscard]] Terrain make_terrain_cached(HeightField field, double max_error_m, const std::vector<RectXZ>& exact,
                                          CookCache& cache);

}  // namespace ff::cook
