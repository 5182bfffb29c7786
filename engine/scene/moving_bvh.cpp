#include "engine/scene/moving_bvh.h"

#include <algorithm>

#include "engine/scene/bvh_builder.h"
#include "engine/scene/instance_bounds.h"

namespace ff::scene {

std::span<const BvhNode> MovingBvh::build(std::span<const Instance> instances, const WorldPos& origin) {
    items_.clear();
    nodes_.clear();
    for (std::size_t i = 0; i < instances.size(); ++i)
        if (!instances[i].bounds.is_empty())
            items_.push_back({relative_box(instances[i].bounds, origin), std::uint32_t(i)});
    if (!items_.empty()) add_node(items_);
    return nodes_;
}

std::uint32_t MovingBvh::add_node(std::span<Item> items) {
    const auto id = std::uint32_t(nodes_.size());
    nodes_.push_back(empty_bvh_node());
    // Halved until there are as many groups as children, the largest first.
    std::span<Item> groups[kBvhWidth] = {items};
    int count = 1;
    while (count < kBvhWidth) {
        const auto largest =
            std::max_element(groups, groups + count, [](const auto& a, const auto& b) { return a.size() < b.size(); });
        if (largest->size() < 2) break;
        Box3 centers;
        for (const Item& item : *largest) centers.add(item.box.center());
        const Vec3 extent = centers.extent();
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const std::size_t half = largest->size() / 2;
        std::nth_element(largest->begin(), largest->begin() + std::ptrdiff_t(half), largest->end(),
                         [&](const Item& a, const Item& b) {
                             const float ca = a.box.center()[axis], cb = b.box.center()[axis];
                             return ca != cb ? ca < cb : a.id < b.id;
                         });
        groups[count++] = largest->subspan(half);
        *largest = largest->first(half);
    }
    for (int lane = 0; lane < count; ++lane) {
        Box3 box;
        for (const Item& item : groups[lane]) box.add(item.box);
        const bool is_leaf = groups[lane].size() == 1;
        const std::uint32_t child = is_leaf ? kBvhLeafBit | groups[lane].front().id : add_node(groups[lane]);
        set_child(nodes_[id], lane, box, child);
    }
    return id;
}

}  // namespace ff::scene
