#pragma once
// Bodies and characters as components, and the system that steps them.
//
// Dynamic bodies write their entity's LocalTransform (position and rotation; the scale is left alone); kinematic ones
// follow it. So a door is an entity whose LocalTransform the game turns, and that carries a RigidBody.

#include <optional>

#include "engine/ecs/registry.h"
#include "engine/ecs/schedule.h"
#include "engine/physics/physics_world.h"

namespace ff::physics {

/// A body of the PhysicsWorld; use it on entities without a parent.
struct RigidBody {
    BodyId id;
    Motion motion = Motion::dynamic;
};

/// A character; its LocalTransform's position is that of the feet, the rotation is the game's.
struct Walker {
    CharacterId id;
    CharacterInput input;  ///< of the next tick
};

/// Resource: which world is stepped, and what the last step did.
struct PhysicsTick {
    PhysicsWorld* world = nullptr;  ///< borrowed
    StepStats stats;
    std::optional<WorldPos> viewer;  ///< bodies near it are stepped, too; see PhysicsWorld::step
};

/// What step_physics touches.
[[nodiscard]] ecs::Access physics_access();

/// One tick: kinematic bodies and inputs to the world, the step, poses of what moved back to the entities. Bodies and
/// characters that are not alive are left out; a transform or an input that the world refuses stays where it was.
/// Does nothing without a world.
void step_physics(ecs::SystemContext& context);

/// Adds step_physics to a schedule, as "physics".
void add_physics_system(ecs::Schedule& schedule);

/// Makes a body where the entity's LocalTransform is, and gives the entity its RigidBody.
/// Errors: those of PhysicsWorld::add_body; usage: no LocalTransform.
/// @param desc  its pose is not looked at
Result<BodyId> attach_body(ecs::Registry& registry, PhysicsWorld& world, ecs::Entity entity, BodyDesc desc);

/// Removes the entity's body or character from the world, and the component. Call it before the entity is destroyed.
/// @return false where it has neither
bool detach(ecs::Registry& registry, PhysicsWorld& world, ecs::Entity entity);

}  // namespace ff::physics
