#pragma once
// glTF primitives to triangles.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene/animation.h"
#include "engine/scene/scene_data.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/gltf_accessor.h"
#include "tools/cook/gltf_material.h"

namespace ff::cook {

/// The vertex streams of one primitive, as numbers. Streams that are absent are empty.
struct PrimitiveStreams {
    std::vector<float> positions;             ///< 3 a vertex
    std::vector<float> normals;               ///< 3
    std::vector<float> uvs;                   ///< 2
    std::vector<float> colors;                ///< color_components a vertex
    std::size_t color_components = 4;         ///< 3 or 4
    std::vector<std::vector<float>> joints;   ///< of JOINTS_0, JOINTS_1, ..: 4 a vertex
    std::vector<std::vector<float>> weights;  ///< of WEIGHTS_0, ..: same
    std::vector<std::uint32_t> indices;       ///< as in the file; has_indices tells none from empty
    bool has_indices = false;
};

/// What a mesh's vertices say of the joints that they follow.
struct SkinStreams {
    std::size_t joint_count = 0;        ///< in: of the skin
    std::vector<std::uint16_t> joints;  ///< kMostInfluences a vertex, of the skin's
    std::vector<float> weights;         ///< same; greatest first, a vertex's sum is 1
};

/// One glTF mesh with all its primitives. Triangle materials are ids of ImportedMaterials (the default one for a
/// primitive without). Thread-safe: meshes may be read in parallel.
/// @param skin  null: the mesh is not skinned. A vertex that follows more than kMostInfluences joints keeps the
/// heaviest,
///              one that follows none the first.
/// Errors, of skins: joints that the skin does not have; weights below 0; JOINTS_n without WEIGHTS_n.
[[nodiscard]] Result<scene::MeshSource> read_mesh(const GltfData& data, std::size_t mesh,
                                                  const ImportedMaterials& materials, CookContext& context,
                                                  SkinStreams* skin = nullptr);

}  // namespace ff::cook
