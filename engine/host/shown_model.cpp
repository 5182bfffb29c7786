#include "engine/host/shown_model.h"

#include "engine/scene/instance_bounds.h"

namespace ff::host {

glm::quat turn_of(double yaw) {
    return glm::angleAxis(float(-yaw), Vec3(0.0f, 1.0f, 0.0f));
}

ShownModel model_of(const scene::NamedPlace& place) {
    return {place.first_instance, place.instance_count, place.first_animated,
            place.animated_count, place.position,       turn_of(place.yaw)};
}

void show_model(const scene::World& world, const ShownModel& model, const WorldPos& at, const glm::quat& turn,
                double seconds, GameView& out) {
    const Mat3 linear = glm::mat3_cast(turn * glm::inverse(model.placed_turn));
    const auto moved = [&](const WorldPos& placed) { return at + DVec3(linear * Vec3(placed - model.placed_at)); };
    for (std::uint32_t i = 0; i < model.instance_count; ++i) {
        const scene::DynamicInstance& part = world.info().dynamic_instances[model.first_instance + i];
        scene::Instance instance{
            .position = moved(part.position), .world_from_mesh = linear * part.world_from_mesh, .mesh = part.mesh};
        instance.bounds = scene::world_box(instance, world.scene().meshes[part.mesh].bounds);
        out.dynamic.push_back(instance);
    }
    const scene::AnimationSet& animation = world.info().animation;
    for (std::uint32_t i = 0; i < model.animated_count; ++i) {
        const scene::AnimatedInstance& placed = animation.instances[model.first_animated + i];
        animation::Animator animator{.model = placed.model};
        animator.now = {.clip = placed.clip, .time_s = seconds};
        out.models.push_back({moved(placed.position), linear * placed.world_from_model, animator});
    }
}

}  // namespace ff::host
