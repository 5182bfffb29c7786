#pragma once
// scene.toml (docs/scene-format.md): a world written by hand, read into plain arrays.

#include <filesystem>

#include "engine/core/result.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

struct SceneTomlSettings {
    int scale = 1;  ///< times the stored content; a [town] grows around its centre, else copies on a grid. [1, 1000]
};

/// Reads a scene and everything that it names: terrain, buildings, town, models, scattered instances, sky, walks.
/// The standard walks are added as well (walks.h).
/// Errors: bad_input `FILE:LINE: [table] key: found; expected ...`. Unknown keys name the nearest known one.
/// Parallel inside; the number of workers never changes the result.
[[nodiscard]] Result<WorldSource> load_scene_toml(const std::filesystem::path& path, const SceneTomlSettings& settings,
                                                  CookContext& context);

}  // namespace ff::cook
