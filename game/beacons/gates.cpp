// Gates that open for who uses them.

#include <algorithm>
#include <glm/geometric.hpp>

#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

constexpr float kOpeningS = 1.6f;  // seconds from shut to open

/// Slow at both ends.
float eased(float share) {
    return share * share * (3.0f - 2.0f * share);
}

void move_gates(ecs::SystemContext& context) {
    const Level& level = *context.resource<const Surroundings>().level;
    const bool uses = context.resource<const PlayerCommand>().pressed(kUse);
    const WorldPos player = context.get<const ecs::LocalTransform>(level.player)->position;
    context.each<ecs::LocalTransform, Before, Gate>([&](ecs::LocalTransform& at, Before& before, Gate& gate) {
        before = {at.position, at.rotation};
        if (uses && glm::distance(at.position, player) < kGateReach) gate.opening = !gate.opening;
        const float step = float(kTick) / kOpeningS;
        gate.open = std::clamp(gate.open + (gate.opening ? step : -step), 0.0f, 1.0f);
        at.rotation = turn_of(gate.closed_yaw + double(gate.swing_rad * eased(gate.open)));
    });
}

}  // namespace

void add_gate_system(ecs::Schedule& schedule) {
    schedule.add("gates",
                 ecs::Access().write<ecs::LocalTransform, Before, Gate>().read_resource<Surroundings, PlayerCommand>(),
                 move_gates);
}

}  // namespace ff::beacons
