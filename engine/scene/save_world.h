#pragma once

#include <cstdint>
#include <filesystem>

#include "engine/assets/pack_writer.h"
#include "engine/core/result.h"
#include "engine/scene/scene_data.h"
#include "engine/scene/world.h"

namespace ff::scene {

/// Writes a pack, whole or not at all; what stood at `path` stays until the new one is complete. Same input, same
/// bytes, for any number of workers. Holds no second copy of the big arrays.
/// @param scene  finished, see SceneData::finish
/// @return the file's size, bytes
/// Errors: failure where the disk refuses, or where the scene breaks a promise that load_world would hold against it
/// (find_world_problem): then the cooker has a mistake.
Result<std::uint64_t> write_world(const std::filesystem::path& path, const SceneData& scene, const WorldInfo& info,
                                  assets::Compression compression = assets::Compression::zstd);

}  // namespace ff::scene
