#pragma once
// A validated glTF document as tinygltf's typed model.

#include <tiny_gltf.h>

#include "engine/core/result.h"
#include "tools/cook/gltf_file.h"

namespace ff::cook {

/// The model without `buffers` and `images` (GltfFile has their bytes: nothing is copied) and without what is not drawn
/// (animations, skins, cameras, extras). Extensions are read from GltfFile::json, where they are as written.
[[nodiscard]] Result<tinygltf::Model> parse_gltf(const GltfFile& file);

}  // namespace ff::cook
