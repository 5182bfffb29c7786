// A group's walk: over the instances, and within each that some of its points may be hidden by.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/sun_group.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "engine/farfield/sun_group.h"
#include "engine/farfield/sun_leaf-inl.h"
#include "engine/farfield/sun_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE Vec3 reach_of_box(const Vec3& low, const Vec3& high) {
    return glm::max(glm::abs(low), glm::abs(high));
}

// Puts a leaf first.
HWY_INLINE void remember(Occluders& occluders, Occluders::Leaf leaf) {
    int at = 0;
    while (at < occluders.count &&
           (occluders.leaves[at].instance != leaf.instance || occluders.leaves[at].leaf != leaf.leaf))
        ++at;
    if (at == occluders.count) at = std::min(occluders.count++, Occluders::kMost - 1);
    occluders.count = std::min(occluders.count, Occluders::kMost);
    for (; at > 0; --at) occluders.leaves[at] = occluders.leaves[at - 1];
    occluders.leaves[0] = leaf;
}

HWY_INLINE bool is_much(std::uint64_t hidden, const PointGroup& group) {
    return 4 * std::popcount(hidden) >= group.count;
}

// Tries what hid the last groups' points.
HWY_INLINE void hide_by_known(const scene::StaticScene& scene, std::uint32_t first_id, const LightFrame& light,
                              Occluders& occluders, const GroupPoints& p, std::uint64_t& left, CastCost& cost) {
    int kept = 0;
    for (int i = 0; i < occluders.count; ++i) {
        const Occluders::Leaf known = occluders.leaves[i];
        const scene::Instance& instance = scene.instances[known.instance];
        const BvhLeaf& leaf = scene.mesh_leaves[scene.meshes[instance.mesh].first_leaf + known.leaf];
        std::uint64_t hidden = 0;
        if (left != 0) {
            const LightRows rows = light_rows(light, instance.world_from_mesh, instance.position - p.group.centre);
            cost.triangles += leaf.triangle_count;
            hidden = hidden_by_leaf({scene, leaf, known.instance, first_id + known.instance, p}, rows, left);
            if (hidden == 0) continue;  // forgotten
        }
        left &= ~hidden;
        occluders.leaves[kept++] = known;
    }
    occluders.count = kept;
}

// Takes from `left` those of the points that the instance hides.
HWY_NOINLINE void hide_by_instance(const scene::StaticScene& scene, std::uint32_t id, std::uint32_t first_id,
                                   const LightFrame& light, const GroupPoints& p, const Slabs& unturned,
                                   Occluders& occluders, std::uint64_t points, std::uint64_t& left, CastCost& cost) {
    const scene::Instance& instance = scene.instances[id];
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const BvhNode* nodes = scene.mesh_nodes.data() + mesh.first_node;
    prefetch_all(nodes);
    const BvhLeaf* leaves = scene.mesh_leaves.data() + mesh.first_leaf;
    const LightRows rows = light_rows(light, instance.world_from_mesh, instance.position - p.group.centre);
    const SunSpace space = sun_space(rows, reach_of_box(mesh.bounds.low, mesh.bounds.high), p.extent);
    Slabs own;
    const bool is_turned = instance.world_from_mesh != Mat3(1.0f);
    if (is_turned) find_slabs(space, p, own);
    walk_sunwards(
        nodes, space, p, is_turned ? own : unturned, points, left, cost.nodes,
        [&](std::uint32_t child) {
            if (child & kBvhLeafBit)
                prefetch_all(leaves + (child & ~kBvhLeafBit));
            else
                prefetch_all(nodes + child);
        },
        [&](std::uint32_t leaf, std::uint64_t of_leaf) {
            cost.triangles += leaves[leaf].triangle_count;
            const std::uint64_t hidden = hidden_by_leaf({scene, leaves[leaf], id, first_id + id, p}, rows, of_leaf);
            left &= ~hidden;
            if (is_much(hidden, p.group)) remember(occluders, {id, leaf});
        });
}

}  // namespace

void CastGroup(const scene::StaticScene& scene, std::uint32_t first_id, const LightFrame& light, Occluders& occluders,
               PointGroup& group, CastCost& cost) {
    if (scene.instance_nodes.empty() || group.left == 0) return;
    const GroupPoints p(group);
    hide_by_known(scene, first_id, light, occluders, p, group.left, cost);
    if (group.left == 0) return;
    const LightRows rows = light_rows(light, Mat3(1.0f), scene.origin - group.centre);
    const Vec3 reach = reach_of_box(Vec3(scene.bounds.low - scene.origin), Vec3(scene.bounds.high - scene.origin));
    const SunSpace space = sun_space(rows, reach, p.extent);
    Slabs slabs;
    find_slabs(space, p, slabs);
    walk_sunwards(
        scene.instance_nodes.data(), space, p, slabs, group.left, group.left, cost.nodes,
        [&](std::uint32_t child) {
            if (child & kBvhLeafBit)
                prefetch_all(scene.instances.data() + (child & ~kBvhLeafBit));
            else
                prefetch_all(scene.instance_nodes.data() + child);
        },
        [&](std::uint32_t id, std::uint64_t points) {
            hide_by_instance(scene, id, first_id, light, p, slabs, occluders, points, group.left, cost);
        });
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::farfield::beam {
HWY_EXPORT(CastGroup);
}

namespace ff::farfield::sun {

LightFrame::LightFrame(const Vec3& to_sun) : s(0.0), t(0.0), d(glm::normalize(DVec3(to_sun))) {
    const DVec3 across = std::abs(d.y) < 0.9 ? DVec3(0, 1, 0) : DVec3(1, 0, 0);
    s = glm::normalize(glm::cross(across, d));
    t = glm::cross(d, s);
}

void cast_group(const scene::StaticScene& scene, std::uint32_t first_id, const LightFrame& light, Occluders& occluders,
                PointGroup& group, CastCost& cost) {
    using namespace beam;
    HWY_DYNAMIC_DISPATCH(CastGroup)(scene, first_id, light, occluders, group, cost);
}

}  // namespace ff::farfield::sun
#endif
