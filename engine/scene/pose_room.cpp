#include "engine/scene/pose_room.h"

#include <algorithm>

#include "engine/core/check.h"

namespace ff::scene {

std::uint32_t pose_count(std::uint32_t vertex_count) {
    constexpr std::uint32_t kVertices = 1u << 18, kFewest = 4;
    return std::clamp(kVertices / std::max(vertex_count, 1u), kFewest, kMostPoses);
}

PoseRoomSize pose_room_size(const AnimationSet& set, std::span<const Mesh> meshes) {
    PoseRoomSize size;
    for (const AnimatedModel& model : set.models)
        for (const Skin& skin : model.skins) {
            const Mesh& mesh = meshes[skin.mesh];
            const std::uint64_t count = pose_count(mesh.vertex_count);
            size.meshes += count;
            size.vertices += count * mesh.vertex_count;
            size.nodes += count * mesh.node_count;
            size.leaves += count * mesh.leaf_count;
        }
    return size;
}

void fill_pose_room(const AnimationSet& set, const PoseRoomSize& used, PoseRoom& room) {
    PoseRoomSize next = used;
    room.slots.clear();
    const auto copy = [](auto span, std::uint64_t from, std::uint64_t count, std::uint64_t& to) {
        FF_CHECK(to + count <= span.size(), "{} and {} of {}", to, count, span.size());
        std::copy_n(span.data() + from, count, span.data() + to);
        to += count;
    };
    for (const AnimatedModel& model : set.models)
        for (const Skin& skin : model.skins) {
            const Mesh mesh = room.meshes[skin.mesh];
            room.slots.push_back({skin.mesh, std::uint32_t(next.meshes), pose_count(mesh.vertex_count)});
            for (std::uint32_t i = 0; i < room.slots.back().count; ++i) {
                Mesh pose = mesh;
                pose.first_vertex = std::uint32_t(next.vertices);
                pose.first_node = std::uint32_t(next.nodes);
                pose.first_leaf = std::uint32_t(next.leaves);
                std::uint64_t vertices = next.vertices;
                copy(room.positions, mesh.first_vertex, mesh.vertex_count, vertices);
                copy(room.attributes, mesh.first_vertex, mesh.vertex_count, next.vertices);
                copy(room.nodes, mesh.first_node, mesh.node_count, next.nodes);
                copy(room.leaves, mesh.first_leaf, mesh.leaf_count, next.leaves);
                room.meshes[next.meshes++] = pose;
            }
        }
}

PoseRoom add_pose_room(const AnimationSet& set, SceneData& scene) {
    const PoseRoomSize size = pose_room_size(set, scene.meshes);
    const PoseRoomSize used{scene.meshes.size(), scene.positions.size(), scene.mesh_nodes.size(),
                            scene.mesh_leaves.size()};
    scene.meshes.resize(used.meshes + size.meshes);
    scene.positions.resize(used.vertices + size.vertices);
    scene.attributes.resize(used.vertices + size.vertices);
    scene.mesh_nodes.resize(used.nodes + size.nodes);
    scene.mesh_leaves.resize(used.leaves + size.leaves);
    PoseRoom room{.slots = {},
                  .meshes = scene.meshes,
                  .positions = scene.positions,
                  .attributes = scene.attributes,
                  .nodes = scene.mesh_nodes,
                  .leaves = scene.mesh_leaves};
    fill_pose_room(set, used, room);
    return room;
}

}  // namespace ff::scene
