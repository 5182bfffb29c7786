// The hierarchy over the instances' boxes, and those boxes.

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/jobs.h"
#include "engine/scene/bvh_builder.h"
#include "engine/scene/instance_bounds.h"
#include "engine/scene/scene_data.h"

namespace ff::scene {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

float rounded_down(double x) {
    const float f = float(x);
    return double(f) > x ? std::nextafter(f, -kInf) : f;
}
float rounded_up(double x) {
    const float f = float(x);
    return double(f) < x ? std::nextafter(f, kInf) : f;
}

}  // namespace

Box3 relative_box(const DBox3& box, const WorldPos& origin) {
    Box3 out;
    for (int axis = 0; axis < 3; ++axis) {
        out.low[axis] = rounded_down(box.low[axis] - origin[axis]);
        out.high[axis] = rounded_up(box.high[axis] - origin[axis]);
    }
    return out;
}

DBox3 world_box(const Instance& instance, const Box3& box) {
    DBox3 out;
    if (box.is_empty()) return out;
    // Each axis of the image is an interval sum (Arvo, "Transforming Axis-Aligned Bounding Boxes", Graphics Gems,
    // 1990).
    for (int row = 0; row < 3; ++row) {
        double low = instance.position[row], high = low;
        for (int column = 0; column < 3; ++column) {
            const double a = double(instance.world_from_mesh[column][row]) * box.low[column];
            const double b = double(instance.world_from_mesh[column][row]) * box.high[column];
            low += std::min(a, b);
            high += std::max(a, b);
        }
        out.low[row] = low;
        out.high[row] = high;
    }
    return out;
}

void build_instance_bvh(std::span<const Instance> instances, const WorldPos& origin, std::vector<BvhNode>& nodes) {
    std::vector<BuildPrimitive> primitives;
    primitives.reserve(instances.size());
    for (std::size_t i = 0; i < instances.size(); ++i) {
        if (instances[i].bounds.is_empty()) continue;
        primitives.push_back({relative_box(instances[i].bounds, origin), std::uint32_t(i)});
    }
    WideBvh bvh = build_wide_bvh(primitives, {.max_leaf_primitives = 1}, [](auto) { return true; });
    nodes = std::move(bvh.nodes);
    for (BvhNode& node : nodes) {
        for (std::uint32_t& child : node.child) {
            if (child == kBvhEmpty || !(child & kBvhLeafBit)) continue;
            child = kBvhLeafBit | primitives[bvh.leaves[child & ~kBvhLeafBit].first].id;
        }
    }
}

}  // namespace ff::scene
