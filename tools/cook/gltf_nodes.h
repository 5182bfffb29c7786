#pragma once
// The node hierarchy flattened: where each mesh of the scene stands.

#include <vector>

#include "engine/core/result.h"
#include "engine/math/types.h"
#include "engine/scene/animation.h"
#include "tools/cook/cook_context.h"
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

/// A mesh that a node shows.
struct NodeMesh {
    std::size_t mesh = 0;        ///< glTF mesh
    std::size_t skin = kNoSkin;  ///< glTF skin; then the node's own transform does not matter
    std::uint32_t joint = 0;     ///< of the skeleton: the node
    scene::Mat4x3 joint_from_mesh{1.0f};
    static constexpr std::size_t kNoSkin = ~std::size_t{0};
};

/// The node hierarchy kept: every node of the scene is a joint, in depth-first order.
struct NodeSkeleton {
    scene::Skeleton skeleton;
    std::vector<std::uint32_t> joint_of_node;  ///< kNoJoint: not of the scene
    std::vector<NodeMesh> meshes;
};

/// Of the same nodes as flatten_nodes. A matrix that shears is warned about: of it the nearest rotation and scale stay.
/// Errors: as flatten_nodes; more nodes than kMostJoints.
[[nodiscard]] Result<NodeSkeleton> read_skeleton(const GltfData& data, CookContext& context);

}  // namespace ff::cook
