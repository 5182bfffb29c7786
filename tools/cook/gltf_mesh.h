#pragma once
// glTF primitives to triangles.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene/scene_data.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/gltf_accessor.h"
#include "tools/cook/gltf_material.h"

namespace ff::cook {

/// The vertex streams of one primitive, as numbers. Streams that are absent are empty.
struct PrimitiveStreams {
    std::vector<float> positions;        ///< 3 a vertex
    std::vector<float> normals;          ///< 3
    std::vector<float> uvs;              ///< 2
    std::vector<float> colors;           ///< color_components a vertex
    std::size_t color_components = 4;    ///< 3 or 4
    std::vector<std::uint32_t> indices;  ///< as in the file; has_indices tells none from empty
    bool has_indices = false;
};

/// One glTF mesh with all its primitives. Triangle materials are ids of ImportedMaterials (the default one for a
/// primitive without). Thread-safe: meshes may be read in parallel.
[[nodiscard]] Result<scene::MeshSource> read_mesh(const GltfData& data, std::size_t mesh,
                                                  const ImportedMaterials& materials, CookContext& context);

}  // namespace ff::cook
