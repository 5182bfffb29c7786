#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene/static_scene.h"

namespace ff::scene {

/// The hierarchy over instances that move, made anew every frame: medians along the longest axis, so quicker to make
/// and somewhat slower to walk than build_instance_bvh, and like it in every other way. Steady frames allocate nothing.
class MovingBvh {
  public:
    /// @param origin  of the scene: boxes are relative to it and rounded outwards
    /// @return the nodes, good until the next build; empty for no instances
    std::span<const BvhNode> build(std::span<const Instance> instances, const WorldPos& origin);

  private:
    struct Item {
        Box3 box;
        std::uint32_t id = 0;
    };
    std::uint32_t add_node(std::span<Item> items);

    std::vector<Item> items_;
    std::vector<BvhNode> nodes_;
};

}  // namespace ff::scene
