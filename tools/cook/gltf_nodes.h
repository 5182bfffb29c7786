#pragma once
// The node hierarchy flattened: where each mesh of the scene stands.

#include <vector>

#include "engine/core/result.h"
#include "engine/math/types.h"
#include "tools/cook/gltf_accessor.h"

namespace ff::cook {

struct NodeInstance {
    std::size_t mesh = 0;  ///< glTF mesh
    DVec3 position{0.0};
    DMat3 model_from_mesh{1.0};
    bool is_flat = false;  ///< model_from_mesh is singular, of rank 2: a mesh squeezed into a plane
};

/// Meshes of the default scene (else the first; else all root nodes), in depth-first order, EXT_mesh_gpu_instancing
/// expanded. Transforms that squeeze a mesh into a line or a point draw nothing and are left out.
/// Errors: instancing attributes of unequal lengths or wrong types.
[[nodiscard]] Result<std::vector<NodeInstance>> flatten_nodes(const GltfData& data);

}  // namespace ff::cook
