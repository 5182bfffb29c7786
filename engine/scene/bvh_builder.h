#pragma once
// Builds the 16-wide hierarchies of bvh.h from boxes: a binary tree by binned SAH, then its best collapse to 16 wide.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine/math/bounds.h"
#include "engine/scene/bvh.h"

namespace ff::scene {

/// One thing to be put into the tree.
struct BuildPrimitive {
    Box3 box;
    std::uint32_t id = 0;
};

/// Says whether primitives may share a leaf; called for at most `BvhBuildSettings::max_leaf_primitives` of them.
using LeafFits = std::function<bool(std::span<const BuildPrimitive>)>;

struct BvhBuildSettings {
    std::uint32_t max_leaf_primitives = BvhLeaf::kMaxTriangles;
    /// How many usually fit a leaf, for the cost of a split. [1, max_leaf_primitives]
    std::uint32_t usual_leaf_primitives = BvhLeaf::kMaxTriangles;
    /// A leaf that fits is split all the same if its halves' areas add up to less than this part of its own. [0, 1]
    float split_gain = 0.5f;
};

/// A range of the ordered primitives that became one leaf.
struct LeafRange {
    std::uint32_t first = 0, count = 0;
};

/// Result of a build: nodes as the casters read them (node 0 is the root; a child with kBvhLeafBit names a LeafRange),
/// leaves in depth-first order, so that their ranges are consecutive.
struct WideBvh {
    std::vector<BvhNode> nodes;
    std::vector<LeafRange> leaves;
};

/// @param primitives  reordered so that every leaf's are consecutive, in leaf order. Not-a-number boxes are tolerated:
///                    they end up somewhere.
/// Deterministic for any number of workers; large inputs use them all.
[[nodiscard]] WideBvh build_wide_bvh(std::span<BuildPrimitive> primitives, const BvhBuildSettings& settings,
                                     const LeafFits& fits);

/// A node without children.
[[nodiscard]] BvhNode empty_bvh_node();
void set_child(BvhNode& node, int lane, const Box3& box, std::uint32_t child);

}  // namespace ff::scene
