// The player walks, looks, and raises the spyglass.

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/physics/systems.h"
#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {

glm::quat turn_of(double yaw) {
    return glm::angleAxis(float(-yaw), Vec3(0.0f, 1.0f, 0.0f));
}

DVec3 look_direction(const PlayerView& view) {
    const double yaw = view.yaw_urad * 1e-6, pitch = view.pitch_urad * 1e-6;
    return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), -std::cos(yaw) * std::cos(pitch)};
}

DVec3 eye_above_feet() {
    return {0.0, kEyeHeight, 0.0};
}

namespace {

void move_player(ecs::SystemContext& context) {
    const loop::UserCommand& command = context.resource<const PlayerCommand>().now;
    PlayerView& view = context.resource<PlayerView>();
    view.yaw_urad = command.yaw_urad;
    view.pitch_urad = command.pitch_urad;
    // Nine tenths of the way in a third of a second; by ratio, for that is how a zoom is seen.
    const double wished = command.held(kSpyglass) ? kSpyglassFov : kFov;
    view.fov *= std::exp(std::log(wished / view.fov) * 7.0 * kTick);

    const double yaw = command.yaw_urad * 1e-6;
    Vec3 wish(float(command.move_right), 0.0f, float(-command.move_ahead));
    wish /= float(loop::UserCommand::kFull);
    if (const float length = glm::length(wish); length > 1.0f) wish /= length;
    const bool runs = command.held(kRun) && !command.held(kSpyglass);
    wish *= runs ? kRunning : kWalk;
    const auto sin = float(std::sin(yaw)), cos = float(std::cos(yaw));
    const ecs::Entity player = context.resource<const Surroundings>().level->player;
    const auto& at = *context.get<const ecs::LocalTransform>(player);
    *context.get<Before>(player) = {at.position, at.rotation};
    auto* walker = context.get<physics::Walker>(player);
    walker->input = {.velocity_m_s = {wish.x * cos - wish.z * sin, 0.0f, wish.x * sin + wish.z * cos},
                     .jump = command.held(kJump),
                     .crouch = false};
}

}  // namespace

void add_player_system(ecs::Schedule& schedule) {
    schedule.add("player",
                 ecs::Access()
                     .write<physics::Walker, Before>()
                     .read<ecs::LocalTransform>()
                     .read_resource<PlayerCommand, Surroundings>()
                     .write_resource<PlayerView>(),
                 move_player);
}

}  // namespace ff::beacons
