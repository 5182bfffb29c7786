#pragma once
// Walks of the hierarchies that the scene carries, to the triangles that a resting or moving box may touch. Nothing is
// built: a world of any size costs the collision code nothing where nobody is.
//
// Based on: Kay, Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986 (slabs). Ours differs: the ray has an extent, by
// which the boxes grow, so that the same walk finds what rests, what is swept and what is looked at.

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/math/bounds.h"
#include "engine/scene/static_scene.h"

namespace ff::physics {

/// A box whose centre goes from `from` to `from + along`; metres, world. `along` may be 0.
struct SweptBox {
    DVec3 from{0.0};
    DVec3 along{0.0};
    DVec3 half{0.0};
};

/// A mesh put somewhere: an instance of the scene, or a body.
struct PlacedMesh {
    DVec3 position{0.0};
    DMat3 world_from_mesh{1.0};
    DMat3 mesh_from_world{1.0};
    std::uint32_t mesh = 0;
    std::uint32_t instance = 0;  ///< of the scene; meaningless for a body
};
[[nodiscard]] inline PlacedMesh placed(const scene::Instance& instance, std::uint32_t id) {
    const DMat3 linear(instance.world_from_mesh);
    return {instance.position, linear, glm::inverse(linear), instance.mesh, id};
}

/// Whether a triangle of a leaf stops anything: masked foliage does not.
[[nodiscard]] inline bool is_solid(const scene::StaticScene& scene, const scene::Mesh& mesh, const scene::BvhLeaf& leaf,
                                   int triangle) {
    if (((leaf.alpha_triangles >> triangle) & 1u) == 0) return true;
    const std::uint32_t id = mesh.first_triangle + leaf.first_triangle + std::uint32_t(triangle);
    return (scene.materials[scene.triangle_materials[id]].flags & scene::kMaterialAlphaMask) == 0;
}
[[nodiscard]] inline DVec3 leaf_corner(const scene::BvhLeaf& leaf, int triangle, int corner) {
    const int v = leaf.corner[corner][triangle];
    return {leaf.x[v], leaf.y[v], leaf.z[v]};
}

namespace detail {

/// The swept box as the nodes' float boxes are held against it, grown by what rounding may take.
struct NodeTest {
    Vec3 from, inverse_along, grow;

    NodeTest(const DVec3& from_d, const DVec3& along, const DVec3& half, double reach)
        : from(from_d), inverse_along(0.0f), grow(0.0f) {
        for (int axis = 0; axis < 3; ++axis) {
            // Finite, so that 0 times it is 0: a box that does not move along an axis is inside the slab or never.
            const double inverse = along[axis] == 0.0 ? 1e30 : 1.0 / along[axis];
            inverse_along[axis] = float(std::clamp(inverse, -1e30, 1e30));
            grow[axis] = float(half[axis] + 1e-6 * (std::abs(from_d[axis]) + std::abs(along[axis]) + reach) + 1e-6);
        }
    }

    /// Where along the way each lane's box is entered; +inf where it is not before `limit`.
    void enter(const scene::BvhNode& node, float limit, std::array<float, scene::kBvhWidth>& out) const {
        constexpr float inf = std::numeric_limits<float>::infinity();
        for (std::size_t lane = 0; lane < std::size_t(scene::kBvhWidth); ++lane) {
            const float ax = (node.low_x[lane] - grow.x - from.x) * inverse_along.x;
            const float bx = (node.high_x[lane] + grow.x - from.x) * inverse_along.x;
            const float ay = (node.low_y[lane] - grow.y - from.y) * inverse_along.y;
            const float by = (node.high_y[lane] + grow.y - from.y) * inverse_along.y;
            const float az = (node.low_z[lane] - grow.z - from.z) * inverse_along.z;
            const float bz = (node.high_z[lane] + grow.z - from.z) * inverse_along.z;
            const float near = std::max(std::max(std::min(ax, bx), std::min(ay, by)), std::max(std::min(az, bz), 0.0f));
            const float far = std::min(std::min(std::max(ax, bx), std::max(ay, by)), std::min(std::max(az, bz), limit));
            out[lane] = near <= far * 1.00001f + 1e-6f ? near : inf;
        }
    }
};

/// Visits the leaves of one hierarchy, near ones first. @param nodes  node 0 is the root
template <class Limit, class Leaf>
void walk_nodes(const scene::BvhNode* nodes, const NodeTest& test, Limit&& limit, Leaf&& leaf) {
    struct Entry {
        std::uint32_t child;
        float enter;
    };
    // A node's 16 lanes replace it: 15 more a level, and check_world.h allows 64 levels.
    constexpr std::size_t kEntries = 64 * 15 + 1;
    Entry stack[kEntries];
    std::size_t size = 0;
    stack[size++] = {0, 0.0f};
    std::array<float, scene::kBvhWidth> enter;
    while (size > 0) {
        const Entry entry = stack[--size];
        if (entry.enter > limit() * 1.00001f + 1e-6f) continue;
        if ((entry.child & scene::kBvhLeafBit) != 0) {
            leaf(entry.child & ~scene::kBvhLeafBit);
            continue;
        }
        const scene::BvhNode& node = nodes[entry.child];
        test.enter(node, limit(), enter);
        const std::size_t first = size;
        for (std::size_t lane = 0; lane < std::size_t(scene::kBvhWidth) && size < kEntries; ++lane) {
            if (node.child[lane] == scene::kBvhEmpty || enter[lane] == std::numeric_limits<float>::infinity()) continue;
            // Insertion sort, farthest first, ties by lane: the nearest is popped first.
            std::size_t at = size++;
            for (; at > first && stack[at - 1].enter < enter[lane]; --at) stack[at] = stack[at - 1];
            stack[at] = {node.child[lane], enter[lane]};
        }
    }
}

}  // namespace detail

/// Visits the leaves of a placed mesh that the box may touch before limit() (part of the way, [0, 1], read again and
/// again: a visitor that has found something lowers it). leaf(mesh, leaf).
template <class Limit, class Leaf>
void walk_mesh(const scene::StaticScene& scene, const PlacedMesh& placed, const SweptBox& box, Limit&& limit,
               Leaf&& leaf) {
    const scene::Mesh& mesh = scene.meshes[placed.mesh];
    if (mesh.node_count == 0) return;
    const DMat3& m = placed.mesh_from_world;
    DVec3 half(0.0);
    for (int column = 0; column < 3; ++column) half += glm::abs(m[column]) * box.half[column];
    const double reach = double(std::max(glm::length(mesh.bounds.low), glm::length(mesh.bounds.high)));
    const detail::NodeTest test(m * (box.from - placed.position), m * box.along, half, reach);
    detail::walk_nodes(scene.mesh_nodes.data() + mesh.first_node, test, limit,
                       [&](std::uint32_t id) { leaf(mesh, scene.mesh_leaves[mesh.first_leaf + id]); });
}

/// The same for all instances of the scene. leaf(placed, mesh, leaf).
template <class Limit, class Leaf>
void walk_scene(const scene::StaticScene& scene, const SweptBox& box, Limit&& limit, Leaf&& leaf) {
    if (scene.instance_nodes.empty()) return;
    const double reach =
        std::max(glm::length(scene.bounds.low - scene.origin), glm::length(scene.bounds.high - scene.origin));
    const detail::NodeTest test(box.from - scene.origin, box.along, box.half, reach);
    detail::walk_nodes(scene.instance_nodes.data(), test, limit, [&](std::uint32_t id) {
        const PlacedMesh at = placed(scene.instances[id], id);
        walk_mesh(scene, at, box, limit, [&](const scene::Mesh& mesh, const scene::BvhLeaf& l) { leaf(at, mesh, l); });
    });
}

}  // namespace ff::physics
