#pragma once
// What every first-person game needs again: keys to walk with, a wish made of a command, eyes above feet.

#include <initializer_list>
#include <string>
#include <vector>

#include "engine/loop/controls.h"
#include "engine/loop/user_command.h"
#include "engine/math/camera.h"
#include "engine/physics/character.h"

namespace ff::host {

/// An action of the game and the keys that do it before the player changes them; see loop::parse_trigger.
/// FF_CHECKs that there are such keys, and no more than an action can have.
[[nodiscard]] loop::Action action(std::string name, std::initializer_list<const char*> triggers);

/// W, A, S and D, in the order that loop::Controls wants; the game's own actions follow.
[[nodiscard]] std::vector<loop::Action> walking_actions();

/// What somebody wants who walks as the command says.
/// @param speed_m_s  at full tilt; slanting is no faster
[[nodiscard]] physics::CharacterInput walking_input(const loop::UserCommand& command, float speed_m_s, bool jump);

/// What is seen from above the feet. @param eye_height_m  above them
[[nodiscard]] Camera eyes_above(const WorldPos& feet, double eye_height_m, const loop::UserCommand& command,
                                double fov);

}  // namespace ff::host
