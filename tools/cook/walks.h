#pragma once
// The five walks that every pack gets, and the spawn point of a scene that names none (formats.md, Walkthroughs).

#include <filesystem>

#include "engine/core/result.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Puts the spawn point on the ground in the densest free part of the world: not inside geometry, facing along the
/// longer free way. An empty world keeps the origin.
void choose_spawn(WorldSource& world);

/// Appends `street`, `orbit`, `flyover`, `turn` and `sprint` where no walk of that name is there yet. `street` is a jog
/// of 40 m at 3 m/s around a corner near the spawn point (a stroll would end before it). Positions are whole
/// micrometres: the same on every machine.
/// Takes time in proportion to the triangles; makes no use of randomness.
void make_standard_walks(WorldSource& world);

/// Reads a *.walk.json file. Errors: bad_input with file, place and expectation.
[[nodiscard]] Result<SourceWalk> read_walk_file(const std::filesystem::path& path, const std::string& name);

}  // namespace ff::cook
