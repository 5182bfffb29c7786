#pragma once
// The model that stands at a named place of the world, shown wherever the game wants it.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>

#include "engine/host/game.h"
#include "engine/scene/world.h"

namespace ff::host {

/// Meshes of the world that move: where they are in WorldInfo, and where the world has put them.
struct ShownModel {
    std::uint32_t first_instance = 0, instance_count = 0;  ///< of WorldInfo::dynamic_instances
    std::uint32_t first_animated = 0, animated_count = 0;  ///< likewise, of AnimationSet::instances
    WorldPos placed_at{0.0};
    glm::quat placed_turn{1.0f, 0.0f, 0.0f, 0.0f};
};

/// A rotation by a yaw, radians as Camera::yaw.
[[nodiscard]] glm::quat turn_of(double yaw);

/// The place's model; nothing is shown of one that was not cooked with `dynamic = true`.
[[nodiscard]] ShownModel model_of(const scene::NamedPlace& place);

/// Adds the model to what is shown, moved as a whole from where the world has it.
/// @param world    that the model is of
/// @param seconds  of its animation
void show_model(const scene::World& world, const ShownModel& model, const WorldPos& at, const glm::quat& turn,
                double seconds, GameView& out);

}  // namespace ff::host
