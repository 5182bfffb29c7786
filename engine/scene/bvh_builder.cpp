// Based on: Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007 (binning); Ylitie, Karras,
// Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3 (the collapse
// of least SAH cost by dynamic programming; here 16 wide and with the leaves of the binary tree kept).

#include "engine/scene/bvh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/core/check.h"
#include "engine/core/jobs.h"

namespace ff::scene {
namespace {

constexpr int kBins = 16;
constexpr std::size_t kParallelPrimitives = 1u << 15;  // smaller subtrees are one task
constexpr int kDeepest = 100;  // from here on halves: no tree has more than 32 levels below, whatever its boxes

struct BinaryNode {
    Box3 box;
    std::uint32_t first = 0, count = 0;
    std::uint32_t right = 0;  // the left child follows its parent; 0: a leaf
};

float half_area(const Box3& box) {
    if (box.is_empty()) return 0.0f;
    const Vec3 e = box.extent();
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

struct Split {
    int axis = -1;
    int bin = 0;  // the first bin of the right side
    float cost = std::numeric_limits<float>::infinity();
};

class BinaryBuilder {
  public:
    BinaryBuilder(std::span<BuildPrimitive> primitives, const BvhBuildSettings& settings, const LeafFits& fits)
        : primitives_(primitives), settings_(settings), fits_(fits) {}

    // Nodes of [first, first + count) in preorder, `right` relative to the vector's beginning.
    std::vector<BinaryNode> build(std::size_t first, std::size_t count, int depth) const {
        std::vector<BinaryNode> nodes;
        if (count < kParallelPrimitives) {
            nodes.reserve(count / 2 + 1);
            build_serial(first, count, depth, nodes);
            return nodes;
        }
        BinaryNode node;
        const std::size_t left_count = split(first, count, depth, node);
        if (left_count == 0) {
            nodes.push_back(node);
            return nodes;
        }
        std::array<std::vector<BinaryNode>, 2> sides;
        parallel_for(2, [&](std::size_t side) {
            sides[side] = side == 0 ? build(first, left_count, depth + 1)
                                    : build(first + left_count, count - left_count, depth + 1);
        });
        node.right = std::uint32_t(1 + sides[0].size());
        nodes.reserve(1 + sides[0].size() + sides[1].size());
        nodes.push_back(node);
        std::uint32_t offset = 1;
        for (std::vector<BinaryNode>& side : sides) {
            for (BinaryNode& child : side) {
                if (child.right != 0) child.right += offset;
                nodes.push_back(child);
            }
            offset += std::uint32_t(side.size());
        }
        return nodes;
    }

  private:
    void build_serial(std::size_t first, std::size_t count, int depth, std::vector<BinaryNode>& nodes) const {
        BinaryNode node;
        const std::size_t left_count = split(first, count, depth, node);
        const std::size_t at = nodes.size();
        nodes.push_back(node);
        if (left_count == 0) return;
        build_serial(first, left_count, depth + 1, nodes);
        nodes[at].right = std::uint32_t(nodes.size());
        build_serial(first + left_count, count - left_count, depth + 1, nodes);
    }

    // Fills the node and reorders its primitives; returns how many go left, 0 for a leaf.
    std::size_t split(std::size_t first, std::size_t count, int depth, BinaryNode& node) const {
        const std::span<BuildPrimitive> range = primitives_.subspan(first, count);
        Box3 centroids;
        for (const BuildPrimitive& p : range) {
            node.box.add(p.box);
            centroids.add(p.box.center());
        }
        node.first = std::uint32_t(first);
        node.count = std::uint32_t(count);
        const bool may_be_leaf = count <= settings_.max_leaf_primitives && fits_(range);
        if (count == 1) return 0;
        const Split best = find_split(range, centroids);
        if (may_be_leaf && (best.axis < 0 || best.cost >= settings_.split_gain * half_area(node.box))) return 0;
        if (best.axis < 0 || depth >= kDeepest) return count / 2;  // all centroids in one place: any halves do
        const float low = centroids.low[best.axis], scale = bin_scale(centroids, best.axis);
        const auto middle = std::partition(range.begin(), range.end(), [&](const BuildPrimitive& p) {
            return bin_of(p.box.center()[best.axis], low, scale) < best.bin;
        });
        return std::size_t(middle - range.begin());
    }

    // What a subtree of so many primitives will cost, in leaves: near the bottom only whole leaves count.
    [[nodiscard]] float leaf_count_of(std::size_t count) const {
        return float((count + settings_.usual_leaf_primitives - 1) / settings_.usual_leaf_primitives);
    }

    static float bin_scale(const Box3& centroids, int axis) {
        const float extent = centroids.high[axis] - centroids.low[axis];
        return extent > 0.0f && std::isfinite(extent) ? float(kBins) * 0.9999f / extent : 0.0f;
    }
    static int bin_of(float center, float low, float scale) {
        const float bin = (center - low) * scale;
        return bin > 0.0f ? std::min(int(std::min(bin, float(kBins))), kBins - 1) : 0;  // a NaN goes into bin 0
    }

    [[nodiscard]] Split find_split(std::span<const BuildPrimitive> range, const Box3& centroids) const {
        std::array<std::array<Box3, kBins>, 3> boxes;
        std::array<std::array<std::uint32_t, kBins>, 3> counts{};
        Vec3 scale;
        for (int axis = 0; axis < 3; ++axis) scale[axis] = bin_scale(centroids, axis);
        for (const BuildPrimitive& p : range) {
            const Vec3 center = p.box.center();
            for (int axis = 0; axis < 3; ++axis) {
                const int bin = bin_of(center[axis], centroids.low[axis], scale[axis]);
                boxes[axis][bin].add(p.box);
                ++counts[axis][bin];
            }
        }
        Split best;
        for (int axis = 0; axis < 3; ++axis) {
            if (scale[axis] == 0.0f) continue;
            std::array<float, kBins> right_cost{};
            Box3 box;
            std::size_t count = 0;
            for (int bin = kBins - 1; bin > 0; --bin) {
                box.add(boxes[axis][bin]);
                count += counts[axis][bin];
                right_cost[bin] = half_area(box) * leaf_count_of(count);
            }
            box = Box3{};
            count = 0;
            for (int bin = 1; bin < kBins; ++bin) {
                box.add(boxes[axis][bin - 1]);
                count += counts[axis][bin - 1];
                if (count == 0 || count == range.size()) continue;
                const float cost = half_area(box) * leaf_count_of(count) + right_cost[bin];
                if (cost < best.cost) best = {axis, bin, cost};
            }
        }
        return best;
    }

    std::span<BuildPrimitive> primitives_;
    const BvhBuildSettings& settings_;
    const LeafFits& fits_;
};

// Least sum of node areas of a binary subtree written as a forest of at most i + 1 wide nodes or leaves.
struct CollapsePlan {
    std::array<float, kBvhWidth> cost;
    std::array<std::uint8_t, kBvhWidth> left_share;  // trees that go to the left child; 0: as with one tree fewer
};

class Collapser {
  public:
    explicit Collapser(std::span<const BinaryNode> nodes) : nodes_(nodes), plans_(nodes.size()) {
        for (std::size_t n = nodes.size(); n-- > 0;) plan(n);  // children stand behind their parents
    }

    WideBvh emit() {
        WideBvh out;
        out.nodes.push_back(empty_bvh_node());
        if (nodes_[0].right == 0) {
            set_child(out.nodes[0], 0, nodes_[0].box, kBvhLeafBit);
            out.leaves.push_back({nodes_[0].first, nodes_[0].count});
        } else {
            fill(0, 0, out);
        }
        return out;
    }

  private:
    void plan(std::size_t n) {
        CollapsePlan& own = plans_[n];
        own.left_share.fill(0);
        own.cost.fill(0.0f);
        if (nodes_[n].right == 0) return;  // a leaf costs the same wherever it hangs
        const CollapsePlan& left = plans_[n + 1];
        const CollapsePlan& right = plans_[nodes_[n].right];
        for (int trees = 2; trees <= kBvhWidth; ++trees) {
            float best = std::numeric_limits<float>::infinity();
            int share = 1;
            for (int k = 1; k < trees; ++k) {
                const float cost = left.cost[k - 1] + right.cost[trees - k - 1];
                if (cost < best) {
                    best = cost;
                    share = k;
                }
            }
            own.cost[trees - 1] = best;
            own.left_share[trees - 1] = std::uint8_t(share);
        }
        own.cost[0] = own.cost[kBvhWidth - 1] + half_area(nodes_[n].box);
        for (int trees = 2; trees <= kBvhWidth; ++trees) {
            if (own.cost[trees - 2] < own.cost[trees - 1]) {
                own.cost[trees - 1] = own.cost[trees - 2];
                own.left_share[trees - 1] = 0;
            }
        }
        own.left_share[0] = 0;
    }

    // The roots of the forest of at most `trees` trees that stands for node n.
    void gather(std::uint32_t n, int trees, std::array<std::uint32_t, kBvhWidth>& roots, int& count) const {
        while (trees > 1 && nodes_[n].right != 0 && plans_[n].left_share[trees - 1] == 0) --trees;
        if (trees == 1 || nodes_[n].right == 0) {
            roots[std::size_t(count++)] = n;
            return;
        }
        const int share = plans_[n].left_share[trees - 1];
        gather(n + 1, share, roots, count);
        gather(nodes_[n].right, trees - share, roots, count);
    }

    void fill(std::uint32_t n, std::uint32_t wide, WideBvh& out) const {
        std::array<std::uint32_t, kBvhWidth> roots{};
        int count = 0;
        // The node itself is opened with the full width, whatever its plan for one tree says.
        int trees = kBvhWidth;
        while (plans_[n].left_share[trees - 1] == 0) --trees;
        const int share = plans_[n].left_share[trees - 1];
        gather(n + 1, share, roots, count);
        gather(nodes_[n].right, trees - share, roots, count);
        for (int lane = 0; lane < count; ++lane) {
            const BinaryNode& child = nodes_[roots[std::size_t(lane)]];
            std::uint32_t id;
            if (child.right == 0) {
                id = kBvhLeafBit | std::uint32_t(out.leaves.size());
                out.leaves.push_back({child.first, child.count});
            } else {
                id = std::uint32_t(out.nodes.size());
                out.nodes.push_back(empty_bvh_node());
                fill(roots[std::size_t(lane)], id, out);
            }
            set_child(out.nodes[wide], lane, child.box, id);
        }
    }

    std::span<const BinaryNode> nodes_;
    std::vector<CollapsePlan> plans_;
};

}  // namespace

BvhNode empty_bvh_node() {
    constexpr float inf = std::numeric_limits<float>::infinity();
    BvhNode node;
    for (int lane = 0; lane < kBvhWidth; ++lane) {
        node.low_x[lane] = node.low_y[lane] = node.low_z[lane] = inf;
        node.high_x[lane] = node.high_y[lane] = node.high_z[lane] = -inf;
        node.child[lane] = kBvhEmpty;
    }
    return node;
}

void set_child(BvhNode& node, int lane, const Box3& box, std::uint32_t child) {
    node.low_x[lane] = box.low.x;
    node.low_y[lane] = box.low.y;
    node.low_z[lane] = box.low.z;
    node.high_x[lane] = box.high.x;
    node.high_y[lane] = box.high.y;
    node.high_z[lane] = box.high.z;
    node.child[lane] = child;
}

WideBvh build_wide_bvh(std::span<BuildPrimitive> primitives, const BvhBuildSettings& settings, const LeafFits& fits) {
    if (primitives.empty()) return {};
    FF_CHECK(primitives.size() < kBvhLeafBit, "{} primitives", primitives.size());
    const std::vector<BinaryNode> binary = BinaryBuilder(primitives, settings, fits).build(0, primitives.size(), 0);
    return Collapser(binary).emit();
}

}  // namespace ff::scene
