#include "tools/cook/coincident_pairs.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <tuple>

#include "engine/core/jobs.h"
#include "engine/math/bounds.h"

namespace ff::cook {
namespace {

using Corners = std::array<DVec3, 3>;

constexpr std::size_t kGrain = 8192;
constexpr std::size_t kLeaf = 8;  // triangles of a leaf
constexpr std::uint32_t kMostPartners =
    1024;                             // of one triangle: keeps a heap of coplanar triangles from being quadratic
constexpr float kParallel = 0.9999f;  // cosine; noise in a small triangle's corners turns its normal

// What the search reads of a triangle.
struct Item {
    Box3 box;          // in the frame of its bucket, see comparable_box
    Vec3 unit_normal;  // facing out; zero without area
    std::uint32_t id = 0;
};

// Planes of like direction, whichever side they face: a square of a cube's face around the direction. In the frame of
// their bucket, boxes of triangles are thin across the plane and tight along walls, however these are turned.
constexpr int kSquares = 17;  // along a face's side; odd, so that the axes' planes lie in the middle of a square
constexpr int kBuckets = 3 * kSquares * kSquares;

/// The rows: across the planes, then along them.
struct Frame {
    std::array<DVec3, 3> axes;

    explicit Frame(int bucket) {
        const int face = bucket / (kSquares * kSquares);
        DVec3 normal(0.0), upright(0.0);
        normal[face] = 1.0;
        normal[(face + 1) % 3] = 2.0 * (bucket % kSquares + 0.5) / kSquares - 1.0;
        normal[(face + 2) % 3] = 2.0 * (bucket / kSquares % kSquares + 0.5) / kSquares - 1.0;
        upright[face == 1 ? 0 : 1] = 1.0;
        axes[0] = glm::normalize(normal);
        axes[1] = glm::normalize(glm::cross(axes[0], upright));
        axes[2] = glm::cross(axes[0], axes[1]);
    }
    [[nodiscard]] DVec3 turned(const DVec3& p) const {
        return {glm::dot(axes[0], p), glm::dot(axes[1], p), glm::dot(axes[2], p)};
    }
};

/// The square of a direction on a face of the cube, the face that it meets first by default.
int face_of(const Vec3& n) {
    const Vec3 size = glm::abs(n);
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}
int square_of(float slope) {
    return std::clamp(static_cast<int>((slope + 1.0f) * (0.5f * kSquares)), 0, kSquares - 1);
}
int bucket_of(const Vec3& n) {
    const int face = face_of(n);
    return (face * kSquares + square_of(n[(face + 2) % 3] / n[face])) * kSquares +
           square_of(n[(face + 1) % 3] / n[face]);
}

/// Calls visit(bucket) for every bucket in which planes parallel to n (within kParallel) may be.
template <class Visit>
void for_each_bucket_near(const Vec3& n, Visit&& visit) {
    constexpr float kReach = 0.045f;  // in slope: acos(kParallel) = 0.0142, three times that at a cube's corner
    const float largest = std::abs(n[face_of(n)]);
    for (int face = 0; face < 3; ++face) {
        if (std::abs(n[face]) < largest - kReach) continue;
        const float u = n[(face + 1) % 3] / n[face], v = n[(face + 2) % 3] / n[face];
        for (int row = square_of(v - kReach); row <= square_of(v + kReach); ++row)
            for (int column = square_of(u - kReach); column <= square_of(u + kReach); ++column)
                visit((face * kSquares + row) * kSquares + column);
    }
}

std::uint64_t spread_bits(std::uint64_t v) {  // abc -> 00a00b00c, 20 bits
    v &= 0x1FFFFFull;
    v = (v | v << 32) & 0x1F00000000FFFFull;
    v = (v | v << 16) & 0x1F0000FF0000FFull;
    v = (v | v << 8) & 0x100F00F00F00F00Full;
    v = (v | v << 4) & 0x10C30C30C30C30C3ull;
    return (v | v << 2) & 0x1249249249249249ull;
}

DVec3 doubled_area(const Corners& t) {
    return glm::cross(t[1] - t[0], t[2] - t[0]);
}

bool overlap(const Box3& a, const Box3& b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
           a.low.z <= b.high.z && b.low.z <= a.high.z;
}

double longest_edge(const Corners& t) {
    return std::max({glm::distance(t[0], t[1]), glm::distance(t[1], t[2]), glm::distance(t[2], t[0])});
}

/// Whether an edge of `a` has all of `b` on its outer side, or within `margin` of it. Both lie in the plane of
/// `normal`, a unit vector towards which `a` turns counter-clockwise.
bool edge_separates(const Corners& a, const Corners& b, const DVec3& normal, double margin) {
    for (std::size_t e = 0; e < 3; ++e) {
        const DVec3 inward = glm::cross(normal, glm::normalize(a[(e + 1) % 3] - a[e]));
        const double limit = glm::dot(inward, a[e]) + margin;
        if (glm::dot(inward, b[0]) <= limit && glm::dot(inward, b[1]) <= limit && glm::dot(inward, b[2]) <= limit)
            return true;
    }
    return false;
}

bool have_same_corners(const Corners& a, const Corners& b, double tolerance) {
    for (const DVec3& p : a)
        if (std::none_of(b.begin(), b.end(), [&](const DVec3& q) { return glm::distance(p, q) <= tolerance; }))
            return false;
    return true;
}

/// The corners are relative to a point nearby.
bool coincide(Corners a, Corners b, double tolerance, bool& same_corners) {
    DVec3 area_a = doubled_area(a), area_b = doubled_area(b);
    // The larger one's plane is the better known: corners are off by the tolerance, whatever the size.
    if (glm::dot(area_a, area_a) < glm::dot(area_b, area_b)) std::swap(a, b), std::swap(area_a, area_b);
    const DVec3 normal = glm::normalize(area_a);
    for (const DVec3& p : b)
        if (std::abs(glm::dot(normal, p - a[0])) > tolerance) return false;
    const double least_height = glm::length(area_b) / longest_edge(b);
    const double margin = std::max(2.0 * tolerance, 0.01 * least_height);
    if (least_height <= margin) return false;  // no wider than the noise
    if (edge_separates(a, b, normal, margin)) return false;
    if (edge_separates(b, a, glm::dot(normal, area_b) < 0.0 ? -normal : normal, margin)) return false;
    same_corners = have_same_corners(a, b, 2.0 * tolerance);
    return true;
}

/// Boxes over the items of a bucket: a complete binary tree, node 1 its root, leaves of kLeaf items from leaf_count on.
struct BoxTree {
    std::size_t leaf_count = 1;
    std::vector<Box3> boxes;

    explicit BoxTree(std::span<const Item> items) {
        leaf_count = std::bit_ceil(std::max<std::size_t>(1, (items.size() + kLeaf - 1) / kLeaf));
        boxes.resize(2 * leaf_count);
        for (std::size_t i = 0; i < items.size(); ++i) boxes[leaf_count + i / kLeaf].add(items[i].box);
        for (std::size_t node = leaf_count - 1; node > 0; --node) {
            boxes[node] = boxes[2 * node];
            boxes[node].add(boxes[2 * node + 1]);
        }
    }

    /// Calls visit(leaf) for every leaf from `first` on whose box meets `box`, ascending, until it returns false.
    template <class Visit>
    void query(const Box3& box, std::size_t first, Visit&& visit) const {
        std::size_t node = 1, leaves = leaf_count;  // leaves: below the node
        for (;;) {
            const std::size_t begin = node * leaves - leaf_count;
            const bool meets = begin + leaves > first && overlap(boxes[node], box);
            if (meets && leaves > 1) {
                node *= 2, leaves /= 2;
                continue;
            }
            if (meets && !visit(begin)) return;
            while (node % 2 == 1) {  // the next one in order: up while a right child, then right
                if (node == 1) return;
                node /= 2, leaves *= 2;
            }
            ++node;
        }
    }
};

/// The box of a triangle in a frame, such that boxes of two that coincide meet and those of neighbours that only touch
/// tend not to: wider by the tolerance across the plane, narrower along it (an overlap counts from two tolerances).
Box3 comparable_box(const Corners& corners, const Frame& frame, const DVec3& middle) {
    DBox3 box;
    for (const DVec3& p : corners) box.add(frame.turned(p - middle));
    const double tolerance = coincidence_tolerance(corners);
    Box3 result;
    for (int axis = 0; axis < 3; ++axis) {
        const double rounding = 1.2e-7 * std::max(std::abs(box.low[axis]), std::abs(box.high[axis]));
        const double grow = axis == 0 ? tolerance + rounding : rounding - 0.6 * tolerance;
        result.low[axis] = static_cast<float>(box.low[axis] - grow);
        result.high[axis] = static_cast<float>(box.high[axis] + grow);
    }
    return result;
}

/// Where a triangle goes in the order: small ones before large ones, of one size class along the Morton curve. Large
/// ones amid small ones would blow up the boxes of the tree.
std::uint64_t order_key(const Box3& box, const Vec3& extent) {
    const Vec3 size = box.extent();
    const float largest = std::max({size.x, size.y, size.z, 1e-9f});
    const auto size_class = static_cast<std::uint64_t>(std::clamp(std::ilogb(largest) / 2 + 8, 0, 15));
    constexpr float kCells = 1048575.0f;
    // Finer across the plane than along it: a query is a thin slab, nodes should be, too.
    const Vec3 at = glm::clamp((box.center() / extent + 0.5f) * kCells, Vec3(0.0f), Vec3(kCells)) *
                    Vec3(1.0f, 1.0f / 64.0f, 1.0f / 64.0f);
    return size_class << 60 | spread_bits(static_cast<std::uint64_t>(at.z)) << 2 |
           spread_bits(static_cast<std::uint64_t>(at.y)) << 1 | spread_bits(static_cast<std::uint64_t>(at.x));
}

/// All triangles with area by bucket, each bucket with its tree.
struct SortedTriangles {
    std::vector<Item> items;
    std::array<std::uint32_t, kBuckets + 1> first{};  // of each bucket's items
    std::vector<Frame> frames;
    std::vector<BoxTree> trees;
    DVec3 middle{0.0};

    explicit SortedTriangles(const PlacedTriangles& triangles) {
        for (int bucket = 0; bucket < kBuckets; ++bucket) frames.emplace_back(bucket);
        const std::size_t count = triangles.size();
        DBox3 bounds;
        for (std::uint32_t id = 0; id < count; ++id) bounds.add(triangles.corners(id)[0]);
        if (!bounds.is_empty()) middle = bounds.center();
        const Vec3 extent(static_cast<float>(bounds.is_empty() ? 1.0 : std::max(1e-6, glm::length(bounds.extent()))));
        struct Order {
            std::uint32_t bucket, id;
            std::uint64_t key;
        };
        std::vector<Item> unsorted(count);
        std::vector<Order> order(count);
        parallel_ranges(count, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const auto id = static_cast<std::uint32_t>(i);
                const Corners corners = triangles.corners(id);
                const DVec3 area = doubled_area(corners) * triangles.facing_sign(id);
                const double length = glm::length(area);
                order[i] = {kBuckets, id, 0};
                if (!(length > 0.0) || !std::isfinite(length)) continue;
                Item& item = unsorted[i];
                item.id = id;
                item.unit_normal = Vec3(area / length);
                order[i].bucket = static_cast<std::uint32_t>(bucket_of(item.unit_normal));
                item.box = comparable_box(corners, frames[order[i].bucket], middle);
                order[i].key = order_key(item.box, extent);
            }
        });
        oneapi::tbb::parallel_sort(order.begin(), order.end(), [](const Order& a, const Order& b) {
            return std::tie(a.bucket, a.key, a.id) < std::tie(b.bucket, b.key, b.id);
        });
        while (!order.empty() && order.back().bucket == kBuckets) order.pop_back();
        items.reserve(order.size());
        for (const Order& at : order) {
            items.push_back(unsorted[at.id]);
            ++first[at.bucket + 1];
        }
        for (int bucket = 0; bucket < kBuckets; ++bucket) first[bucket + 1] += first[bucket];
        trees.reserve(kBuckets);
        for (int bucket = 0; bucket < kBuckets; ++bucket) trees.emplace_back(in_bucket(bucket));
    }

    [[nodiscard]] std::span<const Item> in_bucket(int bucket) const {
        return std::span(items).subspan(first[bucket], first[bucket + 1] - first[bucket]);
    }
};

/// Leaves of a bucket that meet one of its leaves, from that one on: items of a leaf are close, so they share a query.
struct NearLeaves {
    int bucket = -1;
    std::size_t leaf = 0;
    std::vector<std::size_t> leaves;

    void look_from(const SortedTriangles& sorted, int at_bucket, std::size_t at_leaf) {
        if (bucket == at_bucket && leaf == at_leaf) return;
        bucket = at_bucket, leaf = at_leaf;
        leaves.clear();
        const BoxTree& tree = sorted.trees[bucket];
        tree.query(tree.boxes[tree.leaf_count + leaf], leaf, [&](std::size_t met) {
            leaves.push_back(met);
            return true;
        });
    }
};

/// The partners of item i among those after it.
void find_partners(const PlacedTriangles& triangles, const SortedTriangles& sorted, std::size_t i,
                   NearLeaves& near_leaves, std::vector<CoincidentPair>& pairs, bool& complete) {
    const Item& item = sorted.items[i];
    const Corners corners = triangles.corners(item.id);
    const double tolerance = coincidence_tolerance(corners);
    const int own = bucket_of(item.unit_normal);
    std::uint32_t partners = 0;
    const auto visit_item = [&](const Item& other, const Box3& box) {
        const float cosine = glm::dot(item.unit_normal, other.unit_normal);
        if (!overlap(box, other.box) || !(std::abs(cosine) >= kParallel)) return;
        if (!triangles.compares(item.id, other.id)) return;
        Corners here = corners, there = triangles.corners(other.id);
        const double within = std::max(tolerance, coincidence_tolerance(there));
        for (std::size_t c = 0; c < 3; ++c) here[c] -= corners[0], there[c] -= corners[0];
        CoincidentPair pair{
            .first = std::min(item.id, other.id), .second = std::max(item.id, other.id), .same_facing = cosine > 0.0f};
        if (!coincide(here, there, within, pair.same_corners)) return;
        pairs.push_back(pair);
        ++partners;
    };
    const auto visit_leaf = [&](int bucket, std::size_t leaf, const Box3& box) {
        const std::size_t first = sorted.first[bucket], end = sorted.first[bucket + 1];
        for (std::size_t j = std::max(i + 1, first + kLeaf * leaf); j < std::min(first + kLeaf * (leaf + 1), end); ++j)
            visit_item(sorted.items[j], box);
        return partners < kMostPartners;
    };
    for_each_bucket_near(item.unit_normal, [&](int bucket) {
        if (sorted.first[bucket + 1] <= i + 1) return;  // all before
        if (bucket == own) {
            near_leaves.look_from(sorted, own, (i - sorted.first[own]) / kLeaf);
            for (const std::size_t leaf : near_leaves.leaves)
                if (overlap(sorted.trees[own].boxes[sorted.trees[own].leaf_count + leaf], item.box) &&
                    !visit_leaf(own, leaf, item.box))
                    break;
            return;
        }
        const Box3 box = comparable_box(corners, sorted.frames[bucket], sorted.middle);
        sorted.trees[bucket].query(box, 0, [&](std::size_t leaf) { return visit_leaf(bucket, leaf, box); });
    });
    complete = complete && partners < kMostPartners;
}

}  // namespace

double coincidence_tolerance(const std::array<DVec3, 3>& corners) {
    double largest = 0.0;
    for (const DVec3& p : corners) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    return std::min(8.0 * largest * 0x1p-24, 0.25e-3);
}

CoincidentPairs find_coincident_pairs(const PlacedTriangles& triangles) {
    const SortedTriangles sorted(triangles);
    constexpr std::size_t kPart = 1024;
    const std::size_t count = sorted.items.size();
    std::vector<std::vector<CoincidentPair>> parts((count + kPart - 1) / kPart);
    std::atomic<bool> complete = true;
    parallel_for(parts.size(), [&](std::size_t part) {
        bool all = true;
        NearLeaves near_leaves;
        for (std::size_t i = part * kPart; i < std::min((part + 1) * kPart, count); ++i)
            find_partners(triangles, sorted, i, near_leaves, parts[part], all);
        if (!all) complete = false;
    });
    CoincidentPairs found{.pairs = {}, .complete = complete};
    for (const std::vector<CoincidentPair>& part : parts)
        found.pairs.insert(found.pairs.end(), part.begin(), part.end());
    std::sort(found.pairs.begin(), found.pairs.end(), [](const CoincidentPair& a, const CoincidentPair& b) {
        return std::tie(a.first, a.second) < std::tie(b.first, b.second);
    });
    return found;
}

}  // namespace ff::cook
