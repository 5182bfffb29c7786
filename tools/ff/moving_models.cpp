#include "tools/ff/moving_models.h"

#include "engine/scene/instance_bounds.h"

namespace ff::tool {

MovingModels::MovingModels(scene::World& world)
    : world_(world), models_(world), states_(animation::initial_models(world.info().animation)) {
    for (const scene::DynamicInstance& moving : world.info().dynamic_instances) {
        scene::Instance instance{
            .position = moving.position, .world_from_mesh = moving.world_from_mesh, .mesh = moving.mesh};
        instance.bounds = scene::world_box(instance, world.scene().meshes[moving.mesh].bounds);
        instances_.push_back(instance);
    }
    whole_count_ = instances_.size();
}

std::span<const scene::Instance> MovingModels::at(double time_s, const Camera& camera, const ImageSize& size) {
    if (states_.empty()) return instances_;
    animation::set_time(world_.info().animation, time_s, states_);
    const auto posed = models_.pose(states_, make_view(camera, size.width, size.height));
    instances_.resize(whole_count_);
    instances_.insert(instances_.end(), posed.begin(), posed.end());
    return instances_;
}

}  // namespace ff::tool
