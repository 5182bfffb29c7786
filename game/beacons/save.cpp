// The state as bytes, and its fingerprint. Entities are those that populate() makes, so only what systems change is
// kept, in the order of the level's lists.

#include <fmt/format.h>

#include "engine/core/byte_stream.h"
#include "engine/physics/systems.h"
#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

/// Calls visit(number) for every number of what an entity is; the same order for writing, reading and hashing.
template <class T, class Visit>
void visit_vector(T& v, Visit&& visit) {
    visit(v.x);
    visit(v.y);
    visit(v.z);
}

template <class Visit>
void visit_transform(ecs::LocalTransform& at, Before& before, Visit&& visit) {
    visit_vector(at.position, visit);
    visit_vector(before.position, visit);
    for (glm::quat* q : {&at.rotation, &before.rotation}) {
        visit(q->w);
        visit_vector(*q, visit);
    }
}

/// @param begin_entity  called with each entity before its numbers
template <class Begin, class Visit>
void visit_entities(State& state, Begin&& begin_entity, Visit&& visit) {
    ecs::Registry& registry = state.registry;
    const Level& level = state.level;
    const auto each = [&](std::span<const ecs::Entity> entities, auto&& fields) {
        for (const ecs::Entity entity : entities) {
            begin_entity(entity);
            visit_transform(*registry.get<ecs::LocalTransform>(entity), *registry.get<Before>(entity), visit);
            fields(entity);
        }
    };
    each({&level.player, 1}, [&](ecs::Entity entity) { visit_vector(registry.get<Footing>(entity)->feet, visit); });
    each(level.beacons, [&](ecs::Entity entity) {
        auto& beacon = *registry.get<Beacon>(entity);
        visit(beacon.kindled);
        visit(beacon.looked_at);
        visit(beacon.spotted);
        visit(beacon.lit);
    });
    each(level.travellers, [&](ecs::Entity entity) { visit(registry.get<Traveller>(entity)->distance_m); });
    each(level.birds,
         [&](ecs::Entity entity) { visit_vector(registry.get<scenery::Bird>(entity)->velocity_m_s, visit); });
    each(level.gates, [&](ecs::Entity entity) {
        auto& gate = *registry.get<Gate>(entity);
        visit(gate.open);
        visit(gate.opening);
    });
    each(level.bodies, [](ecs::Entity) {});  // beside what physics knows of them
}

template <class Visit>
void visit_session(State& state, Visit&& visit) {
    visit(state.day().tick);
    visit(state.day().stage);
    visit(state.view().fov);
    visit(state.view().yaw_urad);
    visit(state.view().pitch_urad);
    visit(state.command().buttons_before);
}

void write_all(State& state, ByteWriter& out) {
    const auto write = [&](auto& value) { out.value(value); };
    out.value(state.seed);
    visit_session(state, write);
    visit_entities(
        state, [&](ecs::Entity entity) { out.value(entity.index); }, write);
}

}  // namespace

replay::StateDigest digest_of(State& state) {
    replay::StateHash hash;
    const auto add = [&](auto& value) { hash.add(value); };
    visit_session(state, add);
    hash.add(state.physics.hash());
    visit_entities(
        state, [&](ecs::Entity entity) { hash.entity(entity); }, add);
    return hash.digest();
}

std::vector<std::byte> save_state(State& state) {
    std::vector<std::byte> bytes;
    ByteWriter out(bytes);
    write_all(state, out);
    const std::vector<std::byte> physics = state.physics.state();
    out.value(std::uint64_t(physics.size()));
    out.raw(physics);
    return bytes;
}

Status load_state(State& state, std::span<const std::byte> bytes, std::uint32_t version) {
    if (version > kSaveVersion)
        return bad_input(fmt::format("a saved state of version {}; this game reads up to {}", version, kSaveVersion));
    // Checked before anything changes: the same entities, no more and no less.
    std::vector<std::byte> own;
    ByteWriter sizes(own);
    write_all(state, sizes);
    if (bytes.size() < own.size() + 8)
        return bad_input(
            fmt::format("a saved state of {} bytes; this world's has more than {}", bytes.size(), own.size()));
    ByteReader tail(bytes.subspan(own.size()));
    const auto physics = tail.raw(tail.fixed(8));
    if (tail.ended() || tail.left() > 0)
        return bad_input("a saved state of another world, or damaged: its lengths differ");
    FF_TRY(state.physics.set_state(physics));

    ByteReader in(bytes);
    const auto read = [&](auto& value) { in.value(value); };
    read(state.seed);
    visit_session(state, read);
    std::uint32_t index = 0;
    visit_entities(
        state, [&](ecs::Entity) { in.value(index); }, read);
    return {};
}

}  // namespace ff::beacons
