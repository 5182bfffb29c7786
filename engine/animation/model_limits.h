#pragma once
// How far and how fast a model's parts ever get from where it stands: what lets a frame pass by models that cannot be
// seen, and pose distant ones less often.

#include <span>
#include <vector>

#include "engine/animation/skin_tables.h"

namespace ff::animation {

/// Metres from the model's origin that nothing of the model ever leaves, whatever clips are played and however they are
/// blended: joints' greatest distances and scales, added up along the hierarchy. A bound, often twice what is reached.
/// @param skins  [skin of the model]
[[nodiscard]] float find_reach(const scene::AnimatedModel& model, std::span<const scene::Mesh> meshes,
                               std::span<const SkinTables> skins);

/// The greatest speed of any point of the model while a clip plays, metres a second, in model space: from samples 1/64
/// s apart, with a quarter to spare. Where a STEP track jumps it is that jump's.
[[nodiscard]] float find_speed(const scene::AnimatedModel& model, const scene::Clip& clip,
                               std::span<const scene::Mesh> meshes, std::span<const SkinTables> skins);

/// The columns of model_from_joint * joint_from_mesh for a skin's joints.
void find_skin_matrices(const scene::Skin& skin, std::span<const scene::Mat4x3> model_from_joint,
                        std::span<JointColumns> out);

}  // namespace ff::animation
