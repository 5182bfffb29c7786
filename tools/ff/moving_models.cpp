#include "tools/ff/moving_models.h"

#include <cmath>

namespace ff::tool {

MovingModels::MovingModels(scene::World& world, const scenery::ScenerySettings& settings, effects::EffectSet without)
    : world_(world),
      settings_(settings),
      without_(without),
      models_(world),
      standing_(scenery::find_standing(world, true)) {}

Result<std::unique_ptr<MovingModels>> MovingModels::make(scene::World& world, const scenery::ScenerySettings& settings,
                                                         effects::EffectSet without) {
    auto moving = std::unique_ptr<MovingModels>(new MovingModels(world, settings, without));
    FF_TRY(moving->begin());
    return moving;
}

Status MovingModels::begin() {
    const scene::WorldInfo& info = world_.info();
    if (info.flocks.empty() && info.loose_bodies.empty()) return {};
    FF_ASSIGN(scenery_, scenery::Scenery::make(world_, settings_, without_));
    work_ = scenery_->take_work();
    return {};
}

void MovingModels::advance(double time_s, const Camera& viewer) {
    if (!scenery_) return;
    const auto now = std::uint64_t(std::llround(std::max(time_s, 0.0) * scenery::kTicksPerSecond));
    if (now == scenery_->ticks()) return;
    if (now < scenery_->ticks()) {
        const Status begun = begin();
        FF_CHECK(bool(begun), "scenery that was made once is not made again: {}", begun.error().message);
    }
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
