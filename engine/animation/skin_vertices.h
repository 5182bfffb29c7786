#pragma once
// A skinned mesh put into a pose: vertices, normals, leaves and boxes rewritten in place.

#include <span>

#include "engine/animation/skin_tables.h"
#include "engine/scene/bvh.h"

namespace ff::animation {

/// Linear blend skinning: each vertex by the weighted mean of its joints' matrices, its normal by that mean's
/// cofactors, which is right for uneven scales and mirrors, too. Vectors of 4 blend the matrices, whole registers apply
/// them.
/// @param matrices    [joint of the skin]
/// @param positions   [vertex_count], written
/// @param attributes  [vertex_count], of which the normals are written
/// Source: Magnenat-Thalmann, Laperriere, Thalmann, "Joint-dependent local deformations", Graphics Interface 1988.
void skin_vertices(const SkinTables& skin, std::span<const JointColumns> matrices, Vec3* positions,
                   scene::VertexAttributes* attributes);
/// The same, plainly, in double.
void skin_vertices_reference(const SkinTables& skin, std::span<const JointColumns> matrices, Vec3* positions,
                             scene::VertexAttributes* attributes);

/// Brings a mesh's hierarchy up to date with its vertices: the same tree, new boxes, children before parents. Its boxes
/// stay exact, but its quality is that of the pose it was built for.
/// @param positions  of the mesh
/// @param leaves     [leaf_count], their positions are written
/// @param nodes      [node_count], their boxes are written
/// @return the mesh's box
Box3 refit_mesh(const SkinTables& skin, const Vec3* positions, std::span<scene::BvhLeaf> leaves,
                std::span<scene::BvhNode> nodes);

}  // namespace ff::animation
