#pragma once

#include <filesystem>
#include <memory>

#include "engine/assets/pack_reader.h"
#include "engine/core/result.h"
#include "engine/scene/world.h"

namespace ff::scene {

/// Opens a pack. Everything in it is checked here, once (find_world_problem): what comes back can be cast, shaded and
/// drawn without another look, whatever the file's bytes were.
/// Errors: bad_input `FILE@OFFSET (chunk NAME): found; expected ...; cook the world again`; failure without memory.
/// Uses all workers of jobs.h; the result does not depend on their number.
Result<std::unique_ptr<World>> load_world(const std::filesystem::path& path);

/// The same from an open reader.
Result<std::unique_ptr<World>> load_world(const assets::PackReader& reader);

}  // namespace ff::scene
