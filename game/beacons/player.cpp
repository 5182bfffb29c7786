// The player walks, looks, and raises the spyglass.

#include <cmath>

#include "engine/host/first_person.h"
#include "engine/physics/systems.h"
#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {

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

    const bool runs = command.held(kRun) && !command.held(kSpyglass);
    const ecs::Entity player = context.resource<const Surroundings>().level->player;
    const auto& at = *context.get<const ecs::LocalTransform>(player);
    *context.get<Before>(player) = {at.position, at.rotation};
    auto* walker = context.get<physics::Walker>(player);
    auto* footing = context.get<Footing>(player);
    physics::PhysicsWorld& physics = *context.resource<physics::PhysicsTick>().world;
    const physics::CharacterState state = physics.character(walker->id);
    if (state.on_ground) footing->feet = state.position;
    const scene::StaticScene& scene = context.resource<const Surroundings>().level->world->scene();
    // It can only be refused for a position that is no number, and this one has been stood upon.
    if (state.position.y < scene.bounds.low.y - kAbyss) (void)physics.set_position(walker->id, footing->feet);
    walker->input = host::walking_input(command, runs ? kRunning : kWalk, command.held(kJump));
}

}  // namespace

void add_player_system(ecs::Schedule& schedule) {
    schedule.add("player",
                 ecs::Access()
                     .write<physics::Walker, Before, Footing>()
                     .read<ecs::LocalTransform>()
                     .read_resource<PlayerCommand, Surroundings>()
                     .write_resource<PlayerView, physics::PhysicsTick>(),
                 move_player);
}

}  // namespace ff::beacons
