#include "engine/physics/systems.h"

#include "engine/ecs/transform_hierarchy.h"

namespace ff::physics {

using ecs::LocalTransform;

ecs::Access physics_access() {
    ecs::Access access;
    access.read<RigidBody>().write<Walker, LocalTransform>().write_resource<PhysicsTick>();
    return access;
}

void step_physics(ecs::SystemContext& context) {
    PhysicsTick& tick = context.resource<PhysicsTick>();
    if (tick.world == nullptr) return;
    PhysicsWorld& world = *tick.world;

    // What the world refuses (not alive, not finite) stays where it was: a broken script must not stop the game.
    context.each<const RigidBody, const LocalTransform>([&](const RigidBody& body, const LocalTransform& local) {
        if (body.motion == Motion::kinematic && world.is_alive(body.id))
            (void)bool(world.move_kinematic(body.id, {local.position, local.rotation}));
    });
    context.each<const Walker>([&](const Walker& walker) { (void)bool(world.set_input(walker.id, walker.input)); });

    tick.stats = tick.viewer ? world.step({&*tick.viewer, 1}) : world.step();

    context.each<const RigidBody, LocalTransform>([&](const RigidBody& body, LocalTransform& local) {
        if (body.motion != Motion::dynamic || !world.is_alive(body.id)) return;
        const Pose pose = world.body(body.id).pose;
        local.position = pose.position;
        local.rotation = pose.rotation;
    });
    context.each<const Walker, LocalTransform>([&](const Walker& walker, LocalTransform& local) {
        if (world.is_alive(walker.id)) local.position = world.character(walker.id).position;
    });
}

void add_physics_system(ecs::Schedule& schedule) {
    schedule.add("physics", physics_access(), step_physics);
}

Result<BodyId> attach_body(ecs::Registry& registry, PhysicsWorld& world, ecs::Entity entity, BodyDesc desc) {
    const LocalTransform* const local = registry.get<LocalTransform>(entity);
    if (local == nullptr) return usage_error("a body for an entity without a LocalTransform");
    desc.pose = {local->position, local->rotation};
    FF_ASSIGN(const BodyId id, world.add_body(desc));
    registry.add<RigidBody>(entity, {id, desc.motion});
    return id;
}

bool detach(ecs::Registry& registry, PhysicsWorld& world, ecs::Entity entity) {
    bool found = false;
    if (const RigidBody* const body = registry.get<RigidBody>(entity)) {
        world.remove_body(body->id);
        registry.remove<RigidBody>(entity);
        found = true;
    }
    if (const Walker* const walker = registry.get<Walker>(entity)) {
        world.remove_character(walker->id);
        registry.remove<Walker>(entity);
        found = true;
    }
    return found;
}

}  // namespace ff::physics
