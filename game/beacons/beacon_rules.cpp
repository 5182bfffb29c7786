// Spotting beacons through the spyglass, lighting them, and how the day ends.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

/// What of a beacon is looked for: the middle of its basket.
constexpr DVec3 kBasket{0.0, 5.7, 0.0};

bool is_spotted_from(const physics::PhysicsWorld& physics, const WorldPos& eye, const DVec3& look,
                     const WorldPos& basket) {
    const DVec3 to = basket - eye;
    const double distance = glm::length(to);
    if (distance > kSpotRange || glm::dot(to, look) < distance * std::cos(kSpotAngle)) return false;
    // Not into the beacon itself.
    return physics.can_see(eye, basket - to * std::min(1.0, 1.5 / distance));
}

void tend_beacons(ecs::SystemContext& context) {
    Day& day = context.resource<Day>();
    const Surroundings& surroundings = context.resource<const Surroundings>();
    const Level& level = *surroundings.level;
    const loop::UserCommand& command = context.resource<const PlayerCommand>().now;
    const PlayerView& view = context.resource<const PlayerView>();
    SoundsHeard& heard = context.resource<SoundsHeard>();
    std::erase_if(heard.recent, [&](const sound::SoundEvent& e) { return e.at_s < double(day.tick) * kTick - 1.0; });
    const WorldPos feet = context.get<const ecs::LocalTransform>(level.player)->position;
    const WorldPos eye = feet + eye_above_feet();
    const DVec3 look = look_direction(view);
    const bool spies = command.held(kSpyglass) && view.fov < 2.0 * kSpyglassFov;
    bool all_lit = true;
    for (const ecs::Entity entity : level.beacons) {
        Beacon& beacon = *context.get<Beacon>(entity);
        const WorldPos at = context.get<const ecs::LocalTransform>(entity)->position;
        // One line of sight a tick at most: a beacon's turn comes every so many ticks.
        const bool due = (day.tick + beacon.number) % level.beacons.size() == 0;
        if (!beacon.spotted && due) {
            const bool seen = spies && is_spotted_from(*surroundings.physics, eye, look, at + kBasket);
            beacon.looked_at = seen ? beacon.looked_at + std::uint32_t(level.beacons.size()) : 0;
            beacon.spotted = beacon.looked_at >= kSpotTicks;
        }
        const bool kindles = !beacon.lit && command.held(kUse) && glm::distance(feet, at) < kKindleReach;
        beacon.kindled = kindles ? beacon.kindled + 1 : 0;
        if (beacon.kindled >= kKindleTicks) {
            beacon.lit = beacon.spotted = true;
            if (surroundings.chime != scene::kNoSound)
                heard.recent.push_back({.at_s = double(day.tick + 1) * kTick,
                                        .position = at + kBasket,
                                        .source = {.clip = surroundings.chime, .reference_m = 20.0f}});
        }
        all_lit &= beacon.lit;
    }
    ++day.tick;
    if (all_lit)
        day.stage = host::Stage::won;
    else if (day.tick >= kDayTicks)
        day.stage = host::Stage::lost;
}

}  // namespace

host::SunPosition sun_at(std::uint64_t tick) {
    const std::uint64_t at = std::min<std::uint64_t>(tick, kDayTicks) / kSunStepTicks * kSunStepTicks;
    const double share = double(at) / kDayTicks;
    return {kSunAzimuthStart + share * (kSunAzimuthEnd - kSunAzimuthStart), kSunStart + share * (kSunEnd - kSunStart)};
}

void add_beacon_system(ecs::Schedule& schedule) {
    schedule.add("beacons",
                 ecs::Access()
                     .write<Beacon>()
                     .read<ecs::LocalTransform>()
                     .read_resource<Surroundings, PlayerCommand, PlayerView>()
                     .write_resource<Day, SoundsHeard>(),
                 tend_beacons);
}

}  // namespace ff::beacons
