#include "tools/ff/moving_models.h"

#include <algorithm>
#include <cmath>

namespace ff::tool {

MovingModels::MovingModels(scene::World& world)
    : world_(world), models_(world), standing_(scenery::find_standing(world, true)) {}

Result<std::unique_ptr<MovingModels>> MovingModels::make(scene::World& world, const scenery::ScenerySettings& settings,
                                                         effects::EffectSet without) {
    auto moving = std::unique_ptr<MovingModels>(new MovingModels(world));
    moving->without_ = without;
    const scene::WorldInfo& info = world.info();
    if (!info.flocks.empty() || !info.loose_bodies.empty()) {
        FF_ASSIGN(moving->scenery_, scenery::Scenery::make(world, settings, without));
        moving->work_ = moving->scenery_->take_work();
    }
    return moving;
}

void MovingModels::advance(double time_s, const Camera& viewer) {
    if (!scenery_) return;
    const auto now = std::uint64_t(std::llround(std::max(time_s, 0.0) * scenery::kTicksPerSecond));
    if (now == scenery_->ticks()) return;
    if (now < scenery_->ticks()) scenery_->reset();
    while (scenery_->ticks() < now) scenery_->tick(viewer);
    work_ = scenery_->take_work();
}

std::span<const scene::Instance> MovingModels::at(double time_s, const Camera& camera, const ImageSize& size,
                                                  effects::EffectSet without) {
    instances_.clear();
    states_.clear();
    for (const scenery::ShownModel& model : standing_)
        scenery::show_model(world_, model, model.placed_at, model.placed_turn, time_s, instances_, states_);
    if (scenery_) scenery_->show(instances_, states_, without_ | without);
    if (states_.empty()) return instances_;
    const auto posed = models_.pose(states_, make_view(camera, size.width, size.height));
    instances_.insert(instances_.end(), posed.begin(), posed.end());
    return instances_;
}

}  // namespace ff::tool
