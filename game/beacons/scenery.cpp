// What the engine moves in the game: birds and bodies, and the player's own body among them.

#include "engine/core/work_clock.h"
#include "engine/physics/systems.h"
#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

void remember(ecs::SystemContext& context) {
    const auto keep = [](const ecs::LocalTransform& at, Before& before) { before = {at.position, at.rotation}; };
    context.each<const ecs::LocalTransform, Before, const scenery::Bird>(
        [&](const ecs::LocalTransform& at, Before& before, const scenery::Bird&) { keep(at, before); });
    context.each<const ecs::LocalTransform, Before, const physics::RigidBody>(
        [&](const ecs::LocalTransform& at, Before& before, const physics::RigidBody& body) {
            if (body.motion == physics::Motion::dynamic) keep(at, before);
        });
}

void look_at_birds(ecs::SystemContext& context) {
    scenery::Flocks& flocks = context.resource<scenery::Flocks>();
    flocks.viewer =
        context.get<const ecs::LocalTransform>(context.resource<const Surroundings>().level->player)->position;
    flocks.vertical_fov = context.resource<const PlayerView>().fov;
    scenery::move_birds(context);
}

}  // namespace

void add_scenery_systems(ecs::Schedule& schedule) {
    schedule.add("remember",
                 ecs::Access().write<Before>().read<ecs::LocalTransform, scenery::Bird, physics::RigidBody>(),
                 remember);
    schedule.add("birds", scenery::bird_access().read_resource<Surroundings, PlayerView>(), look_at_birds);
    physics::add_physics_system(schedule);
}

}  // namespace ff::beacons
