#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/animation/dynamic_models.h"
#include "engine/core/result.h"
#include "engine/scene/world.h"
#include "engine/scenery/scenery.h"
#include "tools/ff/commands.h"

namespace ff::tool {

/// All that moves in a world that nobody plays: what a pack places, each animated model playing its clip, birds flying,
/// bodies falling.
class MovingModels {
  public:
    /// The world must outlive this; nobody else may pose its models. Errors: those of scenery::Scenery::make.
    /// @param without  effects that are off: those of them that are simulated are not
    static Result<std::unique_ptr<MovingModels>> make(scene::World& world, const scenery::ScenerySettings& settings,
                                                      effects::EffectSet without);

    /// Ticks what is simulated up to a time since the start, or begins anew where that has passed already.
    /// @param viewer  from where it is looked at meanwhile
    void advance(double time_s, const Camera& viewer);
    /// What the ticks of the last time that advance() had any to make did.
    [[nodiscard]] const effects::Simulations& work() const { return work_; }

    /// The instances of a frame: those that move as a whole first.
    /// @param time_s   since the start of the walk
    /// @param without  effects whose things are left out, or stand where the world has put them
    /// @return good until the next call
    std::span<const scene::Instance> at(double time_s, const Camera& camera, const ImageSize& size,
                                        effects::EffectSet without = 0);

    [[nodiscard]] const animation::PoseStats& stats() const { return models_.stats(); }

  private:
    explicit MovingModels(scene::World& world);

    const scene::World& world_;
    animation::DynamicModels models_;
    std::vector<scenery::ShownModel> standing_;  // what no simulation moves
    std::unique_ptr<scenery::Scenery> scenery_;  // null: the world calls for none
    effects::EffectSet without_ = 0;
    effects::Simulations work_;
    std::vector<animation::ModelState> states_;
    std::vector<scene::Instance> instances_;
};

}  // namespace ff::tool
