#pragma once
// The five walks that every pack gets, and the spawn point of a scene that names none (formats.md, Walkthroughs).

#include <filesystem>

#include "engine/core/result.h"
#include "tools/cook/cook_cache.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Appends `street`, `orbit`, `flyover`, `turn` and `sprint` where no walk of that name is there yet. `street` is a jog
/// of 40 m at 3 m/s around a corner near the spawn point (a stroll would end before it). Positions are whole
/// micrometres: the same on every machine.
/// Where the scene has no spawn point of its own, first puts it on the ground in the densest free part of the world:
/// not inside geometry, facing along the longer free way. An empty world keeps the origin. Takes time in proportion to
/// the triangles, unless the cache has seen the same geometry; makes no use of randomness.
void add_spawn_and_walks(WorldSource& world, bool has_spawn, CookCache& cache);

/// Reads a *.walk.json file. Errors: bad_input with file, place and expectation.
[[nodiscard]] Result<SourceWalk> read_walk_file(const std::filesystem::path& path, const std::string& name);

}  // namespace ff::cook
