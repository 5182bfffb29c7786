#include "engine/scenery/shown_model.h"

#include "engine/scene/instance_bounds.h"

namespace ff::scenery {

glm::quat turn_of(double yaw) {
    return glm::angleAxis(float(-yaw), Vec3(0.0f, 1.0f, 0.0f));
}

ShownModel model_of(const scene::MovingModel& placed) {
    return {placed.first_instance, placed.instance_count, placed.first_animated,
            placed.animated_count, placed.position,       turn_of(placed.yaw)};
}

void show_model(const scene::World& world, const ShownModel& model, const WorldPos& at, const glm::quat& turn,
                double seconds, std::vector<scene::Instance>& instances, std::vector<animation::ModelState>& models) {
    const Mat3 linear = glm::mat3_cast(turn * glm::inverse(model.placed_turn));
    const auto moved = [&](const WorldPos& placed) { return at + DVec3(linear * Vec3(placed - model.placed_at)); };
    for (std::uint32_t i = 0; i < model.instance_count; ++i) {
        const scene::DynamicInstance& part = world.info().dynamic_instances[model.first_instance + i];
        scene::Instance instance{
            .position = moved(part.position), .world_from_mesh = linear * part.world_from_mesh, .mesh = part.mesh};
        instance.bounds = scene::world_box(instance, world.scene().meshes[part.mesh].bounds);
        instances.push_back(instance);
    }
    const scene::AnimationSet& animation = world.info().animation;
    for (std::uint32_t i = 0; i < model.animated_count; ++i) {
        const scene::AnimatedInstance& placed = animation.instances[model.first_animated + i];
        animation::Animator animator{.model = placed.model};
        animator.now = {.clip = placed.clip, .time_s = seconds};
        if (placed.clip != scene::kNoClip)
            animator.now.time_s += placed.phase * animation.models[placed.model].clips[placed.clip].duration_s;
        models.push_back({moved(placed.position), linear * placed.world_from_model, animator});
    }
}

std::vector<ShownModel> find_standing(const scene::World& world, bool with_named) {
    const scene::WorldInfo& info = world.info();
    std::vector<bool> moves(info.dynamic_instances.size()), animated_moves(info.animation.instances.size());
    const auto leave_out = [&](const scene::MovingModel& model) {
        for (std::uint32_t i = 0; i < model.instance_count; ++i) moves[model.first_instance + i] = true;
        for (std::uint32_t i = 0; i < model.animated_count; ++i) animated_moves[model.first_animated + i] = true;
    };
    if (!with_named)
        for (const scene::NamedPlace& place : info.places) leave_out(place);
    for (const scene::Flock& flock : info.flocks) leave_out(flock.model);
    for (const scene::LooseBody& body : info.loose_bodies) leave_out(body.model);
    std::vector<ShownModel> out;
    for (std::uint32_t i = 0; i < moves.size(); ++i)
        if (!moves[i]) out.push_back({.first_instance = i, .instance_count = 1});
    for (std::uint32_t i = 0; i < animated_moves.size(); ++i)
        if (!animated_moves[i]) out.push_back({.first_animated = i, .animated_count = 1});
    return out;
}

}  // namespace ff::scenery
