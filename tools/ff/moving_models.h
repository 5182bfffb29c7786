#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/animation/dynamic_models.h"
#include "engine/scene/world.h"
#include "tools/ff/commands.h"

namespace ff::tool {

/// All that moves in a world that nobody plays: what a pack places, each animated model playing its clip.
class MovingModels {
  public:
    /// The world must outlive this; nobody else may pose its models.
    explicit MovingModels(scene::World& world);

    /// The instances of a frame: those that move as a whole first.
    /// @param time_s  since the start of the walk
    /// @return good until the next call
    std::span<const scene::Instance> at(double time_s, const Camera& camera, const ImageSize& size);

    [[nodiscard]] const animation::PoseStats& stats() const { return models_.stats(); }

  private:
    const scene::World& world_;
    animation::DynamicModels models_;
    std::vector<animation::ModelState> states_;
    std::vector<scene::Instance> instances_;
    std::size_t whole_count_ = 0;
};

}  // namespace ff::tool
