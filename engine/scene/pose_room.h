#pragma once
// Room in a scene's arrays for meshes in poses. A skinned mesh is drawn through copies of it: each has vertices, nodes
// and leaves of its own, rewritten when its pose changes, and the triangles of the mesh it was made from. So to whoever
// finds, shades or shadows a triangle a pose is a mesh like any other, named by Instance::mesh.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene/animation.h"
#include "engine/scene/scene_data.h"

namespace ff::scene {

/// Copies of one skinned mesh: StaticScene::meshes[first, first + count).
struct PoseSlots {
    std::uint32_t mesh = 0;  ///< that it was made from; its own arrays stay as they were bound
    std::uint32_t first = 0, count = 0;
};

/// The scene's own arrays, to be written by whoever poses; nobody may read them meanwhile.
struct PoseRoom {
    std::vector<PoseSlots> slots;  ///< one entry a skinned mesh, in the order of models and their skins
    std::span<Mesh> meshes;
    std::span<Vec3> positions;
    std::span<VertexAttributes> attributes;
    std::span<BvhNode> nodes;
    std::span<BvhLeaf> leaves;
};

/// What the copies take in each of the arrays.
struct PoseRoomSize {
    std::uint64_t meshes = 0, vertices = 0, nodes = 0, leaves = 0;
};

/// As many different poses of a mesh can be seen at once: the nearest get one of their own.
inline constexpr std::uint32_t kMostPoses = 32;
/// Copies of a mesh of that many vertices; large ones get fewer, at least 4.
[[nodiscard]] std::uint32_t pose_count(std::uint32_t vertex_count);

[[nodiscard]] PoseRoomSize pose_room_size(const AnimationSet& set, std::span<const Mesh> meshes);

/// Fills the ends of arrays that were made longer by pose_room_size with copies of the meshes as they are bound.
/// @param room  spans over the arrays, room included; its slots are set
/// @param used  of the arrays, without the room
void fill_pose_room(const AnimationSet& set, const PoseRoomSize& used, PoseRoom& room);

/// Appends the room to a scene in memory; the spans are good until its arrays change.
[[nodiscard]] PoseRoom add_pose_room(const AnimationSet& set, SceneData& scene);

}  // namespace ff::scene
