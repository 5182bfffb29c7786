#pragma once

#include "engine/core/result.h"
#include "tools/cook/gltf_file.h"

namespace ff::cook {

/// The same promise as validate_gltf's for skins and animations: every index in range, every word known. What the
/// accessors hold is looked at when they are read. The rest of the document has been validated.
[[nodiscard]] Status validate_animation(const GltfFile& file);

}  // namespace ff::cook
