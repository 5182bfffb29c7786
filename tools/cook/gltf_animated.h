#pragma once

#include "engine/core/result.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/gltf_accessor.h"
#include "tools/cook/gltf_import.h"

namespace ff::cook {

/// The animated half of import_gltf: appends an AnimatedModel with its meshes to `into`. The document has been
/// validated. Nodes become joints; a mesh that a node shows hangs on it, one with a skin follows the skin's joints.
/// Errors: as import_gltf, `into` is then unchanged.
[[nodiscard]] Result<Model> import_animated(GltfFile& file, const GltfData& data, WorldSource& into,
                                            CookContext& context);

}  // namespace ff::cook
