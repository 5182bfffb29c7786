// Carts on their roads, boats on the water.

#include <cmath>

#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

void move_travellers(ecs::SystemContext& context) {
    const Level& level = *context.resource<const Surroundings>().level;
    const double seconds = double(context.resource<const Day>().tick) * kTick;
    context.each<ecs::LocalTransform, Before, Traveller>(
        [&](ecs::LocalTransform& at, Before& before, Traveller& traveller) {
            before = {at.position, at.rotation};
            traveller.distance_m += double(traveller.speed_m_s) * kTick;
            const PathPoint now = point_on(level.paths[traveller.path], traveller.distance_m);
            at.position = now.position;
            at.position.y += double(traveller.bob_m) * std::sin(1.3 * seconds + double(traveller.path));
            // Turns round corners little by little.
            at.rotation = glm::normalize(glm::slerp(at.rotation, turn_of(now.yaw), float(4.0 * kTick)));
        });
}

}  // namespace

void add_traveller_system(ecs::Schedule& schedule) {
    schedule.add("travellers",
                 ecs::Access().write<ecs::LocalTransform, Before, Traveller>().read_resource<Surroundings, Day>(),
                 move_travellers);
}

}  // namespace ff::beacons
