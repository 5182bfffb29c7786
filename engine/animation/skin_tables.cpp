#include "engine/animation/skin_tables.h"

#include <algorithm>

#include "engine/scene/scene_data.h"

namespace ff::animation {
namespace {

using scene::BvhLeaf;

/// Which vertex each slot of a leaf repeats. Two vertices in one place share a slot; they share their weights, too
/// (the cooker sees to it), so either will do.
void map_leaf(const BvhLeaf& leaf, const std::uint32_t* indices, std::uint32_t* vertices) {
    const auto index = [&](int triangle, int corner) {
        return indices[3 * (std::size_t(leaf.first_triangle) + std::size_t(triangle)) + std::size_t(corner)];
    };
    const int last = leaf.triangle_count - 1;
    if (leaf.triangle_count <= BvhLeaf::kMaxDirect) {
        for (int corner = 0; corner < 3; ++corner)
            for (int i = 0; i < BvhLeaf::kMaxDirect; ++i)
                vertices[corner * BvhLeaf::kMaxDirect + i] = index(std::min(i, last), corner);
    } else {
        for (int i = last; i >= 0; --i)  // the first triangle that uses a slot names its vertex
            for (int corner = 2; corner >= 0; --corner) vertices[leaf.corner[corner][i]] = index(i, corner);
    }
    std::fill(vertices + leaf.vertex_count, vertices + BvhLeaf::kMaxVertices, vertices[leaf.vertex_count - 1]);
}

}  // namespace

SkinTables make_skin_tables(const scene::StaticScene& scene, const scene::Skin& skin) {
    const scene::Mesh& mesh = scene.meshes[skin.mesh];
    SkinTables out{.mesh = skin.mesh, .vertex_count = mesh.vertex_count, .influences = skin.influences};
    const std::size_t padded = (mesh.vertex_count + kSkinPadding - 1) / kSkinPadding * kSkinPadding;
    for (auto* array : {&out.x, &out.y, &out.z, &out.normal_x, &out.normal_y, &out.normal_z}) array->resize(padded);
    out.joints = skin.vertex_joints;
    out.weights = skin.vertex_weights;
    out.joint_boxes.resize(skin.joints.size());
    for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
        const Vec3 p = scene.positions[mesh.first_vertex + v];
        const Vec3 n = scene::decode_normal(scene.attributes[mesh.first_vertex + v].normal_oct);
        out.x[v] = p.x;
        out.y[v] = p.y;
        out.z[v] = p.z;
        out.normal_x[v] = n.x;
        out.normal_y[v] = n.y;
        out.normal_z[v] = n.z;
        for (std::size_t i = v * skin.influences; i < (v + 1) * skin.influences; ++i)
            if (skin.vertex_weights[i] > 0.0f) out.joint_boxes[skin.vertex_joints[i]].add(p);
    }
    out.leaf_vertices.resize(std::size_t(mesh.leaf_count) * BvhLeaf::kMaxVertices);
    for (std::size_t leaf = 0; leaf < mesh.leaf_count; ++leaf)
        map_leaf(scene.mesh_leaves[mesh.first_leaf + leaf], scene.indices.data() + 3 * std::size_t(mesh.first_triangle),
                 out.leaf_vertices.data() + leaf * BvhLeaf::kMaxVertices);
    return out;
}

Box3 posed_bounds(const SkinTables& skin, std::span<const JointColumns> matrices) {
    Box3 out;
    for (std::size_t joint = 0; joint < skin.joint_boxes.size(); ++joint) {
        const Box3& box = skin.joint_boxes[joint];
        if (box.is_empty()) continue;
        // Each axis of the image is an interval sum (Arvo, "Transforming Axis-Aligned Bounding Boxes", 1990).
        Box3 moved;
        for (int row = 0; row < 3; ++row) {
            const auto& m = matrices[joint].column;
            float low = m[3][row], high = low;
            for (int axis = 0; axis < 3; ++axis) {
                const float a = m[axis][row] * box.low[axis], b = m[axis][row] * box.high[axis];
                low += std::min(a, b);
                high += std::max(a, b);
            }
            moved.low[row] = low;
            moved.high[row] = high;
        }
        out.add(moved);
    }
    return out;
}

}  // namespace ff::animation
