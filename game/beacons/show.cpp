// What a frame shows of a state: the camera, everything that moves, and what is written over the picture.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/physics/systems.h"
#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

constexpr std::uint32_t kPale = 0xE6F0F5FFu, kGold = 0xFF4CC3FFu, kDim = 0x80FFFFFFu;

struct Pose {
    WorldPos position;
    glm::quat rotation;
};

Pose between(const Before& before, const ecs::LocalTransform& now, double fraction) {
    return {before.position + fraction * (now.position - before.position),
            glm::normalize(glm::slerp(before.rotation, now.rotation, float(fraction)))};
}

double turned(double angle) {
    return std::remainder(angle, 2.0 * kPi);
}

void show_compass(State& state, const Camera& camera, std::vector<host::HudItem>& out) {
    constexpr double kSpan = radians_of(140.0);
    constexpr float kTop = 0.045f, kHalfWidth = 0.3f;
    const auto place = [&](double yaw) { return 0.5f + 2.0f * kHalfWidth * float(turned(yaw - camera.yaw) / kSpan); };
    const auto is_shown = [&](double yaw) { return std::fabs(turned(yaw - camera.yaw)) < 0.5 * kSpan; };
    out.push_back({.kind = host::HudItem::Kind::line,
                   .at = {0.5f - kHalfWidth, kTop + 0.02f},
                   .to = {0.5f + kHalfWidth, kTop + 0.02f},
                   .size = 0.002f,
                   .color = kDim});
    constexpr std::array kPoints{"N", "NE", "E", "SE", "S", "SW", "W", "NW"};
    for (std::size_t i = 0; i < kPoints.size(); ++i)
        if (const double yaw = kPi / 4.0 * double(i); is_shown(yaw))
            out.push_back(
                {.at = {place(yaw), kTop}, .size = i % 2 == 0 ? 0.032f : 0.022f, .color = kPale, .text = kPoints[i]});
    for (const ecs::Entity entity : state.level.beacons) {
        const Beacon& beacon = *state.registry.get<Beacon>(entity);
        if (!beacon.spotted) continue;
        const DVec3 to = state.registry.get<ecs::LocalTransform>(entity)->position - camera.position;
        const double yaw = std::atan2(to.x, -to.z);
        if (!is_shown(yaw)) continue;
        const double distance = glm::length(to);
        out.push_back({.kind = host::HudItem::Kind::line,
                       .at = {place(yaw), kTop + 0.02f},
                       .to = {place(yaw), kTop + 0.036f},
                       .size = 0.006f,
                       .color = beacon.lit ? kGold : kPale});
        out.push_back({.at = {place(yaw), kTop + 0.052f},
                       .size = 0.02f,
                       .color = beacon.lit ? kGold : kPale,
                       .text = distance < 1000.0 ? fmt::format("{:.0f} m", distance)
                                                 : fmt::format("{:.1f} km", distance * 1e-3)});
    }
}

/// For the list of effects.
void tell_simulations(State& state, effects::Simulations& out) {
    effects::Simulation& birds = out[effects::EffectId::birds];
    birds.is_called_for = !state.level.birds.empty();
    birds.moving = state.registry.resource<scenery::Flocks>().flying;
    birds.systems = birds.is_called_for ? 1 : 0;
    effects::Simulation& bodies = out[effects::EffectId::rigid_bodies];
    bodies.is_called_for = !state.level.bodies.empty();
    bodies.moving = state.registry.resource<physics::PhysicsTick>().stats.bodies_stepped;
    bodies.systems = bodies.is_called_for ? 1 : 0;
}

}  // namespace

void show_hud(State& state, const Camera& camera, std::vector<host::HudItem>& out) {
    show_compass(state, camera, out);
    int lit = 0;
    const Beacon* near_one = nullptr;
    const WorldPos feet = state.registry.get<ecs::LocalTransform>(state.level.player)->position;
    for (const ecs::Entity entity : state.level.beacons) {
        const Beacon& beacon = *state.registry.get<Beacon>(entity);
        lit += beacon.lit ? 1 : 0;
        if (glm::distance(feet, state.registry.get<ecs::LocalTransform>(entity)->position) < kKindleReach)
            near_one = &beacon;
    }
    const std::uint64_t left = state.day().tick < kDayTicks ? (kDayTicks - state.day().tick) / kTicks : 0;
    out.push_back({.at = {0.09f, 0.045f},
                   .size = 0.028f,
                   .color = kGold,
                   .text = fmt::format("{} of {} lit", lit, state.level.beacons.size())});
    out.push_back({.at = {0.92f, 0.045f},
                   .size = 0.028f,
                   .color = left < 120 ? kGold : kPale,
                   .text = fmt::format("{}:{:02}", left / 60, left % 60)});
    if (near_one != nullptr && !near_one->lit) {
        out.push_back({.at = {0.5f, 0.8f}, .size = 0.03f, .color = kPale, .text = "hold USE to light the beacon"});
        out.push_back({.kind = host::HudItem::Kind::bar,
                       .at = {0.4f, 0.83f},
                       .to = {0.2f, 0.012f},
                       .value = float(near_one->kindled) / kKindleTicks,
                       .color = kGold});
    }
    if (state.view().fov < 2.0 * kSpyglassFov)
        out.push_back({.kind = host::HudItem::Kind::line,
                       .at = {0.49f, 0.5f},
                       .to = {0.51f, 0.5f},
                       .size = 0.0015f,
                       .color = kDim});
}

void show_state(State& state, double fraction, host::GameView& out) {
    out.dynamic.clear();
    out.models.clear();
    out.hud.clear();
    out.sounds.clear();
    const double seconds = (double(state.day().tick) + fraction) * kTick;
    ecs::Registry& registry = state.registry;
    const scene::World& world = *state.level.world;
    std::uint32_t number = 0;
    const auto show_entity = [&](ecs::Entity entity) {
        const Pose pose = between(*registry.get<Before>(entity), *registry.get<ecs::LocalTransform>(entity), fraction);
        // No two wings beat as one.
        host::show_model(world, *registry.get<host::ShownModel>(entity), pose.position, pose.rotation,
                         seconds + 0.37 * number++, out);
    };
    const scenery::Flocks& flocks = registry.resource<scenery::Flocks>();
    for (const ecs::Entity entity : state.level.birds)
        if (flocks.is_near(registry.get<scenery::Bird>(entity)->flock)) show_entity(entity);
    for (const auto* entities : {&state.level.travellers, &state.level.gates, &state.level.bodies})
        for (const ecs::Entity entity : *entities) show_entity(entity);
    registry.each_chunk<const ecs::LocalTransform, const sound::SoundSource>(
        [&](std::span<const ecs::Entity> entities, auto places, auto sources) {
            for (std::size_t i = 0; i < entities.size(); ++i)
                if (sources[i].gain > 0.0f) out.sounds.push_back({entities[i].index, places[i].position, sources[i]});
        });
    out.sound_events = registry.resource<SoundsHeard>().recent;
    for (const host::ShownModel& model : state.level.scenery)
        host::show_model(world, model, model.placed_at, model.placed_turn, seconds + 0.37 * number++, out);
    // What burns where a beacon is lit stands in the world at the place of the beacon's fire.
    for (const ecs::Entity entity : state.level.beacons) {
        const Beacon& beacon = *registry.get<Beacon>(entity);
        const scene::NamedPlace* fire = world.find_place("fire");
        if (!beacon.lit || fire == nullptr) continue;
        const auto& at = *registry.get<ecs::LocalTransform>(entity);
        host::show_model(world, host::model_of(*fire), at.position, at.rotation, seconds, out);
    }
    const ecs::Entity player = state.level.player;
    const Pose feet = between(*registry.get<Before>(player), *registry.get<ecs::LocalTransform>(player), fraction);
    out.camera = {.position = feet.position + eye_above_feet(),
                  .yaw = state.view().yaw_urad * 1e-6,
                  .pitch = state.view().pitch_urad * 1e-6,
                  .roll = 0.0,
                  .vertical_fov = state.view().fov};
    out.turn_scale = state.view().fov / kFov;
    out.time_s = seconds;
    tell_simulations(state, out.simulations);
    out.sun = sun_at(state.day().tick);
    show_hud(state, out.camera, out.hud);
}

}  // namespace ff::beacons
