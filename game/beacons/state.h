#pragma once
// Everything that a session changes, and what it is played in.

#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/ecs/schedule.h"
#include "engine/ecs/transform_hierarchy.h"
#include "engine/host/shown_model.h"
#include "engine/physics/physics_world.h"
#include "engine/scene/world.h"
#include "engine/scenery/birds.h"
#include "game/beacons/components.h"
#include "game/beacons/path.h"

namespace ff::beacons {

/// What does not change during a session.
struct Level {
    const scene::World* world = nullptr;
    std::vector<Path> paths;
    std::vector<ecs::Entity> beacons, travellers, birds, gates, bodies;  ///< in the order of their names
    ecs::Entity player;
    std::vector<std::string> names;         ///< by entity index
    std::vector<host::ShownModel> scenery;  ///< what may move but nothing moves: it stays where the world has it
};

// Resources: what systems share.

/// What the player wants in this tick, and which buttons were held in the one before.
struct PlayerCommand {
    loop::UserCommand now;
    std::uint16_t buttons_before = 0;

    [[nodiscard]] bool pressed(int button) const { return now.held(button) && ((buttons_before >> button) & 1) == 0; }
};

struct Day {
    std::uint64_t tick = 0;
    host::Stage stage = host::Stage::playing;
};

/// The player beside what physics knows of him.
struct PlayerView {
    double fov = 0.0;  ///< radians, on its way to what is wished
    std::int32_t yaw_urad = 0, pitch_urad = 0;
};

/// Where systems look things up.
struct Surroundings {
    const Level* level = nullptr;
    const physics::PhysicsWorld* physics = nullptr;
    std::uint32_t chime = scene::kNoSound;  ///< recording of a beacon that is lit
};

struct State {
    State(const scene::World& world, std::uint64_t seed);

    std::uint64_t seed;
    ecs::Registry registry;
    ecs::Schedule schedule;
    physics::PhysicsWorld physics;
    Level level;

    [[nodiscard]] Day& day() { return registry.resource<Day>(); }
    [[nodiscard]] PlayerView& view() { return registry.resource<PlayerView>(); }
    [[nodiscard]] PlayerCommand& command() { return registry.resource<PlayerCommand>(); }
};

/// Makes the entities of a world: beacon.N, gate.N, cart.N and boat.N of its places, the carts' and boats' ways of its
/// walks, its flocks and loose bodies. Errors (bad input): no beacon, a cart or boat without a walk of its name.
Status populate(State& state);

/// Adds the systems of a tick, each in the file of its name.
void add_systems(ecs::Schedule& schedule);
void add_player_system(ecs::Schedule& schedule);
void add_traveller_system(ecs::Schedule& schedule);
/// What the engine moves: birds and bodies.
void add_scenery_systems(ecs::Schedule& schedule);
void add_gate_system(ecs::Schedule& schedule);
void add_beacon_system(ecs::Schedule& schedule);

/// Where the sun stands at a tick.
[[nodiscard]] host::SunPosition sun_at(std::uint64_t tick);
using host::turn_of;
/// The way somebody looks, unit.
[[nodiscard]] DVec3 look_direction(const PlayerView& view);
/// Metres above the feet.
[[nodiscard]] DVec3 eye_above_feet();

[[nodiscard]] replay::StateDigest digest_of(State& state);
inline constexpr std::uint32_t kSaveVersion = 1;
[[nodiscard]] std::vector<std::byte> save_state(State& state);
Status load_state(State& state, std::span<const std::byte> bytes, std::uint32_t version);

/// @param fraction  of the time from the last tick to the next
void show_state(State& state, double fraction, host::GameView& out);
void show_hud(State& state, const Camera& camera, std::vector<host::HudItem>& out);

}  // namespace ff::beacons
