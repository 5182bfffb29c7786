// Based on: Lext, Akenine-Moller, "Towards Rapid Reconstruction for Animated Ray Tracing", Eurographics 2001 (boxes
// refitted, tree kept).

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/animation/refit_mesh.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "engine/animation/skin_vertices.h"

HWY_BEFORE_NAMESPACE();
namespace ff::animation {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using scene::BvhLeaf;
using scene::BvhNode;
constexpr hn::CappedTag<float, 16> f;

template <std::size_t kCount>
HWY_INLINE float least(const float* values) {
    auto v = hn::Load(f, values);
    for (std::size_t i = hn::Lanes(f); i < kCount; i += hn::Lanes(f)) v = hn::Min(v, hn::Load(f, values + i));
    return hn::GetLane(hn::MinOfLanes(f, v));
}
template <std::size_t kCount>
HWY_INLINE float greatest(const float* values) {
    auto v = hn::Load(f, values);
    for (std::size_t i = hn::Lanes(f); i < kCount; i += hn::Lanes(f)) v = hn::Max(v, hn::Load(f, values + i));
    return hn::GetLane(hn::MaxOfLanes(f, v));
}

/// Unused slots repeat a vertex, so all 32 may be read.
HWY_INLINE Box3 move_leaf(const std::uint32_t* vertices, const Vec3* positions, BvhLeaf& leaf) {
    for (int i = 0; i < BvhLeaf::kMaxVertices; ++i) {
        const Vec3 p = positions[vertices[i]];
        leaf.x[i] = p.x;
        leaf.y[i] = p.y;
        leaf.z[i] = p.z;
    }
    constexpr std::size_t kCount = BvhLeaf::kMaxVertices;
    return {{least<kCount>(leaf.x), least<kCount>(leaf.y), least<kCount>(leaf.z)},
            {greatest<kCount>(leaf.x), greatest<kCount>(leaf.y), greatest<kCount>(leaf.z)}};
}

/// Empty lanes are inside out.
HWY_INLINE Box3 box_of(const BvhNode& node) {
    constexpr std::size_t kCount = scene::kBvhWidth;
    return {{least<kCount>(node.low_x), least<kCount>(node.low_y), least<kCount>(node.low_z)},
            {greatest<kCount>(node.high_x), greatest<kCount>(node.high_y), greatest<kCount>(node.high_z)}};
}

Box3 RefitMesh(const std::uint32_t* leaf_vertices, const Vec3* positions, std::span<BvhLeaf> leaves,
               std::span<BvhNode> nodes) {
    for (std::size_t n = nodes.size(); n-- > 0;) {  // a child's number is greater than its parent's
        BvhNode& node = nodes[n];
        for (int lane = 0; lane < scene::kBvhWidth; ++lane) {
            const std::uint32_t child = node.child[lane];
            if (child == scene::kBvhEmpty) continue;
            const std::size_t id = child & ~scene::kBvhLeafBit;
            const Box3 box = (child & scene::kBvhLeafBit) != 0
                                 ? move_leaf(leaf_vertices + id * BvhLeaf::kMaxVertices, positions, leaves[id])
                                 : box_of(nodes[id]);
            node.low_x[lane] = box.low.x;
            node.low_y[lane] = box.low.y;
            node.low_z[lane] = box.low.z;
            node.high_x[lane] = box.high.x;
            node.high_y[lane] = box.high.y;
            node.high_z[lane] = box.high.z;
        }
    }
    return nodes.empty() ? Box3{} : box_of(nodes[0]);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::animation
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::animation {

HWY_EXPORT(RefitMesh);

Box3 refit_mesh(const SkinTables& skin, const Vec3* positions, std::span<scene::BvhLeaf> leaves,
                std::span<scene::BvhNode> nodes) {
    return HWY_DYNAMIC_DISPATCH(RefitMesh)(skin.leaf_vertices.data(), positions, leaves, nodes);
}

}  // namespace ff::animation
#endif
