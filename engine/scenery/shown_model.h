#pragma once
// A model of the world that moves as a whole, shown wherever somebody wants it.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "engine/animation/dynamic_models.h"
#include "engine/scene/world.h"

namespace ff::scenery {

/// Meshes of the world that move: where they are in WorldInfo, and where the world has put them.
struct ShownModel {
    std::uint32_t first_instance = 0, instance_count = 0;  ///< of WorldInfo::dynamic_instances
    std::uint32_t first_animated = 0, animated_count = 0;  ///< likewise, of AnimationSet::instances
    WorldPos placed_at{0.0};
    glm::quat placed_turn{1.0f, 0.0f, 0.0f, 0.0f};
};

/// A rotation by a yaw, radians as Camera::yaw.
[[nodiscard]] glm::quat turn_of(double yaw);

/// What stands there; nothing is shown of a model that was not cooked with `dynamic = true`.
[[nodiscard]] ShownModel model_of(const scene::MovingModel& placed);

/// Adds the model to what is shown, moved as a whole from where the world has it.
/// @param world    that the model is of
/// @param seconds  of its animation, beside the part of it that has passed at the start
void show_model(const scene::World& world, const ShownModel& model, const WorldPos& at, const glm::quat& turn,
                double seconds, std::vector<scene::Instance>& instances, std::vector<animation::ModelState>& models);

/// What of a world's moving models stands where the world has put it: what is of no flock and no loose body.
/// @param with_named  what stands at named places, too, which games move
[[nodiscard]] std::vector<ShownModel> find_standing(const scene::World& world, bool with_named);

}  // namespace ff::scenery
