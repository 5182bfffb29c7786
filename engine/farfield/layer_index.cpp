#include "engine/farfield/layer_index.h"

#include <algorithm>
#include <bit>

#include "engine/core/jobs.h"

namespace ff::farfield {
namespace {

using scene::BvhLeaf;
using scene::BvhNode;
using scene::StaticScene;

bool is_blended(const scene::Mesh& mesh) {
    return (mesh.material_flags & scene::kMaterialBlend) != 0 && mesh.node_count > 0;
}

std::uint16_t blended_triangles(const StaticScene& scene, const scene::Mesh& mesh, const BvhLeaf& leaf) {
    unsigned bits = 0;
    for (unsigned left = leaf.alpha_triangles; left != 0; left &= left - 1) {
        const auto i = unsigned(std::countr_zero(left));
        const std::uint16_t material = scene.triangle_materials[mesh.first_triangle + leaf.first_triangle + i];
        if ((scene.materials[material].flags & scene::kMaterialBlend) != 0) bits |= 1u << i;
    }
    return std::uint16_t(bits);
}

/// Fills the bits of a node and of all under it, asking `leaf_counts(id)` of leaves.
/// @return whether any is set
template <class LeafCounts>
bool mark(const BvhNode* nodes, std::uint32_t id, std::uint16_t* children, const LeafCounts& leaf_counts) {
    unsigned bits = 0;
    for (unsigned lane = 0; lane < unsigned(scene::kBvhWidth); ++lane) {
        const std::uint32_t child = nodes[id].child[lane];
        if (child == scene::kBvhEmpty) continue;
        const bool counts = (child & scene::kBvhLeafBit) != 0 ? leaf_counts(child & ~scene::kBvhLeafBit)
                                                              : mark(nodes, child, children, leaf_counts);
        if (counts) bits |= 1u << lane;
    }
    children[id] = std::uint16_t(bits);
    return bits != 0;
}

/// Whether an instance that the index knows lies under a node and within a distance of the origin.
bool any_within(const StaticScene& scene, const LayerIndex& index, std::uint32_t id, const Vec3& eye, float within) {
    const BvhNode& node = scene.instance_nodes[id];
    for (unsigned bits = index.instance_children[id]; bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        const Vec3 low(node.low_x[lane], node.low_y[lane], node.low_z[lane]);
        const Vec3 high(node.high_x[lane], node.high_y[lane], node.high_z[lane]);
        const Vec3 outside = glm::max(glm::max(low - eye, eye - high), Vec3(0.0f));
        if (!(outside.x * outside.x + outside.y * outside.y + outside.z * outside.z <= within * within)) continue;
        const std::uint32_t child = node.child[lane];
        if ((child & scene::kBvhLeafBit) != 0 || any_within(scene, index, child, eye, within)) return true;
    }
    return false;
}

}  // namespace

LayerIndex make_layer_index(const StaticScene& scene) {
    LayerIndex index;
    const auto& meshes = scene.meshes;
    if (std::none_of(meshes.begin(), meshes.end(), [&](const scene::Mesh& mesh) { return is_blended(mesh); }))
        return index;
    index.mesh_children.resize(scene.mesh_nodes.size());
    index.leaf_triangles.resize(scene.mesh_leaves.size());
    index.instance_children.resize(scene.instance_nodes.size());
    parallel_for(meshes.size(), [&](std::size_t m) {
        const scene::Mesh& mesh = meshes[m];
        if (!is_blended(mesh)) return;
        mark(&scene.mesh_nodes[mesh.first_node], 0, &index.mesh_children[mesh.first_node], [&](std::uint32_t leaf) {
            const std::size_t at = std::size_t(mesh.first_leaf) + leaf;
            index.leaf_triangles[at] = blended_triangles(scene, mesh, scene.mesh_leaves[at]);
            return index.leaf_triangles[at] != 0;
        });
    });
    if (!scene.instance_nodes.empty())
        mark(scene.instance_nodes.data(), 0, index.instance_children.data(),
             [&](std::uint32_t id) { return is_blended(meshes[scene.instances[id].mesh]); });
    return index;
}

bool has_layers_within(const StaticScene& scene, const LayerIndex& index, const WorldPos& eye, double within_m) {
    if (index.instance_children.empty()) return false;
    // The boxes are rounded outwards; what rounding the eye takes is far below the margin.
    const float margin = 1e-5f * float(glm::length(eye - scene.origin)) + 1e-3f;
    return any_within(scene, index, 0, Vec3(eye - scene.origin), float(within_m) + margin);
}

}  // namespace ff::farfield
