#pragma once
// The model that stands at a named place of the world, shown wherever the game wants it.

#include "engine/host/game.h"
#include "engine/scenery/shown_model.h"

namespace ff::host {

using scenery::model_of;
using scenery::ShownModel;
using scenery::turn_of;

/// Adds the model to what is shown, moved as a whole from where the world has it.
/// @param world    that the model is of
/// @param seconds  of its animation
inline void show_model(const scene::World& world, const ShownModel& model, const WorldPos& at, const glm::quat& turn,
                       double seconds, GameView& out) {
    scenery::show_model(world, model, at, turn, seconds, out.dynamic, out.models);
}

}  // namespace ff::host
