#pragma once
// A skinned mesh laid out for the loops that pose it, made once.

#include <span>
#include <vector>

#include "engine/scene/animation.h"
#include "engine/scene/static_scene.h"

namespace ff::animation {

/// model_from_joint * joint_from_mesh of one joint of a skin: columns, the fourth number of each unused.
struct alignas(16) JointColumns {
    float column[4][4];
};

struct SkinTables {
    std::uint32_t mesh = 0;  ///< of StaticScene::meshes, as bound
    std::uint32_t vertex_count = 0, influences = 1;
    /// As bound; [vertex], and zeros behind to whole registers.
    std::vector<float> x, y, z;
    std::vector<float> normal_x, normal_y, normal_z;  ///< unit
    std::vector<std::uint16_t> joints;                ///< [vertex][influence], into the skin's joints
    std::vector<float> weights;                       ///< same; greatest first
    std::vector<std::uint32_t> leaf_vertices;         ///< [leaf][BvhLeaf::kMaxVertices]: vertex of each slot
    std::vector<Box3> joint_boxes;                    ///< [joint of the skin]: around the vertices that follow it
};

inline constexpr std::size_t kSkinPadding = 16;

/// @param scene  holds the mesh as it was bound
[[nodiscard]] SkinTables make_skin_tables(const scene::StaticScene& scene, const scene::Skin& skin);

/// A box around the mesh in a pose, without posing it: a vertex is a mean of where its joints take it, so it lies
/// within the union of the joints' boxes, each taken by its joint. Model space.
[[nodiscard]] Box3 posed_bounds(const SkinTables& skin, std::span<const JointColumns> matrices);

}  // namespace ff::animation
