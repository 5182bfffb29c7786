#pragma once
// What was read of a model, into the world that it becomes part of.

#include <string>
#include <vector>

#include "engine/core/result.h"
#include "tools/cook/gltf_file.h"
#include "tools/cook/gltf_material.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Appends the materials that meshes use, with their textures. Alpha that never matters is dropped from them.
/// @param meshes  whose triangles name materials of `imported`
/// @return the world's id of each material; 0 for those that are not used
/// Errors: more materials than 16-bit ids can name; `into` is then unchanged.
[[nodiscard]] Result<std::vector<std::uint16_t>> append_materials(const GltfFile& file, ImportedMaterials imported,
                                                                  const std::vector<scene::MeshSource>& meshes,
                                                                  WorldSource& into);

/// Appends a mesh whose triangles name materials of the model. @return its id
std::uint32_t append_mesh(std::string name, scene::MeshSource mesh, const std::vector<std::uint16_t>& material_ids,
                          WorldSource& into);

}  // namespace ff::cook
