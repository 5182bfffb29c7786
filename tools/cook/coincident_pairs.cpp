#include "tools/cook/coincident_pairs.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <tuple>

#include "engine/core/jobs.h"
#include "engine/math/bounds.h"

namespace ff::cook {
namespace {

using Corners = std::array<DVec3, 3>;

constexpr std::size_t kGrain = 8192;
constexpr std::size_t kLeaf = 4;  // triangles of a leaf
constexpr std::uint32_t kMostPartners =
    1024;                            // of one triangle: keeps a heap of coplanar triangles from being quadratic
constexpr float kParallel = 0.999f;  // cosine; noise in a small triangle's corners turns its normal

// What the sweep reads of a triangle.
struct Item {
    Box3 box;          // relative to the middle of the world, see comparable_box
    Vec3 unit_normal;  // facing out; zero without area
    std::uint32_t id = 0;
};

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

/// Boxes over the sorted items: a complete binary tree, node 1 its root, leaves of kLeaf items from leaf_count on.
struct BoxTree {
    std::size_t leaf_count = 1;
    std::vector<Box3> boxes;

    explicit BoxTree(const std::vector<Item>& items) {
        leaf_count = std::bit_ceil(std::max<std::size_t>(1, (items.size() + kLeaf - 1) / kLeaf));
        boxes.resize(2 * leaf_count);
        parallel_ranges(items.size() / kLeaf + 1, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t leaf = begin; leaf < end; ++leaf)
                for (std::size_t i = kLeaf * leaf; i < std::min(kLeaf * (leaf + 1), items.size()); ++i)
                    if (items[i].unit_normal != Vec3(0.0f)) boxes[leaf_count + leaf].add(items[i].box);
        });
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

/// The box of a triangle, such that boxes of two that coincide meet and those of neighbours that only touch tend not
/// to: wider by the tolerance across the plane, narrower by twice as much along it (an overlap counts from two
/// tolerances).
Box3 comparable_box(const Corners& corners, const Vec3& unit_normal, const DVec3& middle) {
    DBox3 box;
    for (const DVec3& p : corners) box.add(p - middle);
    const double tolerance = coincidence_tolerance(corners);
    Box3 result;
    for (int axis = 0; axis < 3; ++axis) {
        const double rounding = 1.2e-7 * std::max(std::abs(box.low[axis]), std::abs(box.high[axis]));
        // An axis less than 45 degrees from the plane: an overlap as wide as w reaches over 0.7 w along it.
        const double grow = std::abs(unit_normal[axis]) > 0.7f ? tolerance + rounding : rounding - 0.6 * tolerance;
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
    const Vec3 at = glm::clamp((box.center() / extent + 0.5f) * kCells, Vec3(0.0f), Vec3(kCells));
    return size_class << 60 | spread_bits(static_cast<std::uint64_t>(at.z)) << 2 |
           spread_bits(static_cast<std::uint64_t>(at.y)) << 1 | spread_bits(static_cast<std::uint64_t>(at.x));
}

std::vector<Item> sorted_items(const PlacedTriangles& triangles) {
    const std::size_t count = triangles.size();
    DBox3 bounds;
    for (std::uint32_t id = 0; id < count; ++id) bounds.add(triangles.corners(id)[0]);
    const DVec3 middle = bounds.is_empty() ? DVec3(0.0) : bounds.center();
    const Vec3 extent = bounds.is_empty() ? Vec3(1.0f) : Vec3(glm::max(bounds.extent(), DVec3(1e-6)));
    std::vector<Item> items(count);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(count);
    parallel_ranges(count, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto id = static_cast<std::uint32_t>(i);
            const Corners corners = triangles.corners(id);
            const DVec3 area = doubled_area(corners) * triangles.facing_sign(id);
            const double length = glm::length(area);
            Item& item = items[i];
            item.id = id;
            item.unit_normal = length > 0.0 ? Vec3(area / length) : Vec3(0.0f);
            if (length > 0.0) item.box = comparable_box(corners, item.unit_normal, middle);
            order[i] = {length > 0.0 ? order_key(item.box, extent) : 0, id};
        }
    });
    oneapi::tbb::parallel_sort(order.begin(), order.end());
    std::vector<Item> sorted(count);
    for (std::size_t i = 0; i < count; ++i) sorted[i] = items[order[i].second];
    return sorted;
}

}  // namespace

double coincidence_tolerance(const std::array<DVec3, 3>& corners) {
    double largest = 0.0;
    for (const DVec3& p : corners) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    return std::min(8.0 * largest * 0x1p-24, 0.25e-3);
}

CoincidentPairs find_coincident_pairs(const PlacedTriangles& triangles) {
    const std::vector<Item> items = sorted_items(triangles);
    const BoxTree tree(items);
    CoincidentPairs found;
    std::vector<std::vector<CoincidentPair>> parts((items.size() + kGrain - 1) / kGrain);
    std::atomic<bool> complete = true;
    parallel_for(parts.size(), [&](std::size_t part) {
        for (std::size_t i = part * kGrain; i < std::min((part + 1) * kGrain, items.size()); ++i) {
            const Item& item = items[i];
            if (item.unit_normal == Vec3(0.0f)) continue;
            const Corners corners = triangles.corners(item.id);
            const double tolerance = coincidence_tolerance(corners);
            std::uint32_t partners = 0;
            tree.query(item.box, i / kLeaf, [&](std::size_t leaf) {
                for (std::size_t j = std::max(i + 1, kLeaf * leaf); j < std::min(kLeaf * (leaf + 1), items.size());
                     ++j) {
                    const Item& other = items[j];
                    const float cosine = glm::dot(item.unit_normal, other.unit_normal);
                    if (!(std::abs(cosine) >= kParallel) || !overlap(item.box, other.box)) continue;
                    if (!triangles.compares(item.id, other.id)) continue;
                    Corners here = corners, there = triangles.corners(other.id);
                    const double within = std::max(tolerance, coincidence_tolerance(there));
                    for (std::size_t c = 0; c < 3; ++c) here[c] -= corners[0], there[c] -= corners[0];
                    CoincidentPair pair{.first = std::min(item.id, other.id),
                                        .second = std::max(item.id, other.id),
                                        .same_facing = cosine > 0.0f};
                    if (!coincide(here, there, within, pair.same_corners)) continue;
                    parts[part].push_back(pair);
                    if (++partners == kMostPartners) {
                        complete = false;
                        return false;
                    }
                }
                return true;
            });
        }
    });
    for (const std::vector<CoincidentPair>& part : parts)
        found.pairs.insert(found.pairs.end(), part.begin(), part.end());
    std::sort(found.pairs.begin(), found.pairs.end(), [](const CoincidentPair& a, const CoincidentPair& b) {
        return std::tie(a.first, a.second) < std::tie(b.first, b.second);
    });
    found.complete = complete;
    return found;
}

}  // namespace ff::cook
