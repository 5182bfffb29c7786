// From the names of a world's places to entities.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/physics/systems.h"
#include "engine/scenery/loose_bodies.h"
#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

using scene::NamedPlace;

/// Places called PREFIX.1, PREFIX.2 ... in that order.
std::vector<const NamedPlace*> places_called(const scene::World& world, const std::string& prefix) {
    std::vector<const NamedPlace*> places;
    for (int n = 1;; ++n) {
        const NamedPlace* place = world.find_place(fmt::format("{}.{}", prefix, n));
        if (place == nullptr) return places;
        places.push_back(place);
    }
}

ecs::LocalTransform standing_at(const WorldPos& position, double yaw) {
    return {.position = position, .rotation = turn_of(yaw)};
}

class Populator {
  public:
    explicit Populator(State& state) : s_(state), world_(*state.level.world) {}

    Status run() {
        FF_TRY(add_ground_where_there_is_none());
        add_player();
        add_beacons();
        if (s_.level.beacons.empty())
            return bad_input(fmt::format("{}: has no place called beacon.1; expected one for each beacon of the game",
                                         world_.info().name));
        s_.level.scenery = scenery::find_standing(world_, false);
        FF_TRY(add_travellers("cart", 1.6f, 0.0f));
        FF_TRY(add_travellers("boat", 2.0f, 0.12f));
        add_flocks();
        FF_TRY(add_gates());
        return add_bodies();
    }

  private:
    template <class... Components>
    ecs::Entity add(const std::string& name, const ecs::LocalTransform& at, Components... components) {
        const ecs::Entity entity = s_.registry.create(at, Before{at.position, at.rotation}, std::move(components)...);
        s_.level.names.resize(std::max<std::size_t>(s_.level.names.size(), entity.index + 1));
        s_.level.names[entity.index] = name;
        return entity;
    }

    /// Some worlds are buildings on nothing: there one walks on a level as high as the spawn point.
    Status add_ground_where_there_is_none() {
        constexpr float kReach = 1000.0f;  // metres
        const WorldPos spawn = world_.info().spawn_position;
        if (s_.physics.cast_ray(spawn + DVec3(0.0, 1.0, 0.0), Vec3(0.0f, -1.0f, 0.0f), 1e5)) return {};
        FF_TRY(s_.physics.add_body({.shape = physics::box_shape(Vec3(kReach, 1.0f, kReach)),
                                    .motion = physics::Motion::kinematic,
                                    .pose = {.position = spawn - DVec3(0.0, 1.0, 0.0)}}));
        return {};
    }

    void add_player() {
        const scene::WorldInfo& info = world_.info();
        s_.view() = {kFov, std::int32_t(std::lround(info.spawn_yaw * 1e6)), 0};
        const ecs::LocalTransform at = standing_at(info.spawn_position, info.spawn_yaw);
        const auto character = s_.physics.add_character({.position = at.position});
        s_.level.player = add("the player", at, physics::Walker{character ? *character : physics::CharacterId{}, {}},
                              Footing{at.position});
    }

    void add_beacons() {
        for (const NamedPlace* place : places_called(world_, "beacon"))
            s_.level.beacons.push_back(add(place->name, standing_at(place->position, place->yaw),
                                           Beacon{.number = std::uint32_t(s_.level.beacons.size())}));
    }

    /// Things on the walks that have their names.
    Status add_travellers(const std::string& kind, float speed_m_s, float bob_m) {
        for (const NamedPlace* place : places_called(world_, kind)) {
            const scene::Walk* walk = world_.find_walk(place->name);
            Path path = walk != nullptr ? make_path(*walk) : Path{};
            if (path.points.empty())
                return bad_input(fmt::format("{}: '{}' has no walk of that name that leads anywhere",
                                             world_.info().name, place->name));
            const PathPoint start = point_on(path, 0.0);
            const auto index = std::uint32_t(s_.level.paths.size());
            s_.level.paths.push_back(std::move(path));
            s_.level.travellers.push_back(add(place->name, standing_at(start.position, start.yaw),
                                              host::model_of(*place), Traveller{index, 0.0, speed_m_s, bob_m},
                                              sound_called(kind)));
        }
        return {};
    }

    /// What an entity of that kind sounds like: the world's recording of that name, or nothing.
    sound::SoundSource sound_called(const std::string& kind) const {
        const std::uint32_t clip = scene::find_sound(world_.info().sounds, kind);
        return {.clip = clip, .reference_m = 3.0f, .gain = clip == scene::kNoSound ? 0.0f : 0.6f};
    }

    void add_flocks() {
        scenery::Flocks& flocks = s_.registry.resource<scenery::Flocks>();
        flocks.within_m = kBirdsWithin;
        for (const scene::Flock& flock : world_.info().flocks) {
            const auto index = std::uint32_t(flocks.homes.size());
            flocks.homes.push_back({flock.model.position, flock.radius_m});
            for (std::uint32_t i = 0; i < flock.birds; ++i) {
                const scenery::BirdStart start = scenery::start_of(flocks.homes[index], i, flock.birds, index);
                s_.level.birds.push_back(add(fmt::format("bird {} of flock {}", i + 1, index + 1), start.at,
                                             host::model_of(flock.model), start.bird));
            }
        }
    }

    Status add_bodies() {
        for (const scene::LooseBody& body : world_.info().loose_bodies) {
            const scenery::LooseBodyStart start = scenery::start_of(world_, body);
            const std::string name = fmt::format("loose body {}", s_.level.bodies.size() + 1);
            const ecs::Entity entity =
                add(name, {.position = start.desc.pose.position, .rotation = start.desc.pose.rotation}, start.model);
            if (const auto made = physics::attach_body(s_.registry, s_.physics, entity, start.desc); !made)
                return bad_input(fmt::format("{}: {}: {}", world_.info().name, name, made.error().message));
            s_.level.bodies.push_back(entity);
        }
        return {};
    }

    Status add_gates() {
        for (const NamedPlace* place : places_called(world_, "gate")) {
            const ecs::Entity gate = add(place->name, standing_at(place->position, place->yaw), host::model_of(*place),
                                         Gate{.closed_yaw = place->yaw});
            s_.level.gates.push_back(gate);
            for (std::uint32_t i = 0; i < std::min(1u, place->instance_count); ++i) {
                const scene::DynamicInstance& part = world_.info().dynamic_instances[place->first_instance + i];
                FF_TRY(physics::attach_body(
                    s_.registry, s_.physics, gate,
                    {.shape = physics::mesh_shape(part.mesh), .motion = physics::Motion::kinematic}));
            }
        }
        return {};
    }

    State& s_;
    const scene::World& world_;
};

}  // namespace

State::State(const scene::World& world, std::uint64_t session_seed)
    : seed(session_seed), physics(world.scene(), {.tick_s = kTick}) {
    level.world = &world;
    registry.resource<Surroundings>() = {&level, &physics, scene::find_sound(world.info().sounds, "chime")};
    registry.resource<physics::PhysicsTick>().world = &physics;
    add_systems(schedule);
}

void add_systems(ecs::Schedule& schedule) {
    add_player_system(schedule);
    add_traveller_system(schedule);
    add_gate_system(schedule);
    add_scenery_systems(schedule);
    add_beacon_system(schedule);
}

Status populate(State& state) {
    return Populator(state).run();
}

}  // namespace ff::beacons
