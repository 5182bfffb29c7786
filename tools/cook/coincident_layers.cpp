#include "tools/cook/coincident_layers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>

#include "engine/math/bounds.h"

namespace ff::cook {
namespace {

using Corners = std::array<DVec3, 3>;

/// Sets of triangles or patches that belong together; the least member names a set.
class DisjointSets {
  public:
    explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void unite(std::uint32_t a, std::uint32_t b) {
        a = find(a), b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

DVec3 outward_area(const PlacedTriangles& triangles, std::uint32_t id) {
    const Corners t = triangles.corners(id);
    return 0.5 * triangles.facing_sign(id) * glm::cross(t[1] - t[0], t[2] - t[0]);
}

bool is_see_through(const scene::Material& material) {
    return (material.flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) != 0;
}

/// What moves, before it is known how far.
struct Node {
    CoincidentPatch patch;
    std::uint32_t first_triangle = 0;
    bool see_through = true;  // all of it
    Box3 box;
    double smallest_step = 0;  // that float32 can hold, metres
    int layer = 0;
};

struct Edge {
    std::uint32_t from = 0, to = 0;  // to is the later in the order
    bool same_facing = true;
    auto operator<=>(const Edge&) const = default;
};

/// An edge of a triangle by its corners in mesh space, as bits: what neighbours have in common.
struct MeshEdge {
    std::array<std::uint32_t, 6> bits{};
    std::uint32_t slot = 0, member = 0;
    auto operator<=>(const MeshEdge&) const = default;
    [[nodiscard]] bool joins(const MeshEdge& other) const { return bits == other.bits && slot == other.slot; }
};

/// Groups the triangles (ascending ids) of which neighbours in one plane move together; returns each one's group, named
/// by its least member's index.
std::vector<std::uint32_t> group_neighbours(const PlacedTriangles& triangles, const std::vector<std::uint32_t>& ids,
                                            std::span<const CoincidentPair> pairs) {
    std::vector<MeshEdge> edges;
    edges.reserve(3 * ids.size());
    for (std::uint32_t member = 0; member < ids.size(); ++member) {
        const scene::MeshSource& mesh = triangles.mesh(ids[member]);
        const std::size_t corner = 3 * std::size_t{triangles.triangle(ids[member])};
        const auto bits_of = [&](std::size_t c) {
            const Vec3 p = mesh.positions[mesh.indices[corner + c]] + 0.0f;  // -0 and +0 are one
            return std::array{std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                              std::bit_cast<std::uint32_t>(p.z)};
        };
        for (std::size_t c = 0; c < 3; ++c) {
            auto a = bits_of(c), b = bits_of((c + 1) % 3);
            if (b < a) std::swap(a, b);
            edges.push_back({{a[0], a[1], a[2], b[0], b[1], b[2]}, triangles.slot(ids[member]), member});
        }
    }
    std::sort(edges.begin(), edges.end());
    std::vector<DVec3> normals;
    for (const std::uint32_t id : ids) normals.push_back(glm::normalize(outward_area(triangles, id)));
    DisjointSets sets(ids.size());
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        for (end = begin + 1; end < edges.size() && edges[end].joins(edges[begin]);) ++end;
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = i + 1; j < std::min(end, i + 8); ++j) {
                const std::uint32_t a = edges[i].member, b = edges[j].member;
                if (triangles.material(ids[a]) == triangles.material(ids[b]) &&
                    glm::dot(normals[a], normals[b]) > 0.9999)
                    sets.unite(a, b);
            }
    }
    // A group that overlaps itself (a doubled quad) falls apart into its triangles.
    const auto member_of = [&](std::uint32_t id) {
        return static_cast<std::uint32_t>(std::lower_bound(ids.begin(), ids.end(), id) - ids.begin());
    };
    std::vector<bool> folded(ids.size(), false);
    for (const CoincidentPair& pair : pairs) {
        if (triangles.slot(pair.first) != triangles.slot(pair.second)) continue;
        const std::uint32_t a = sets.find(member_of(pair.first));
        if (a == sets.find(member_of(pair.second))) folded[a] = true;
    }
    std::vector<std::uint32_t> groups(ids.size());
    for (std::uint32_t member = 0; member < ids.size(); ++member) {
        const std::uint32_t group = sets.find(member);
        groups[member] = folded[group] ? member : group;
    }
    return groups;
}

/// The pairs as nodes and edges between them.
class Graph {
  public:
    Graph(const PlacedTriangles& triangles, std::span<const scene::Material> materials,
          std::span<const CoincidentPair> pairs, std::vector<std::uint32_t>& patch_of)
        : triangles_(triangles), materials_(materials), patch_of_(patch_of) {
        make_patches(pairs);
        for (const CoincidentPair& pair : pairs) {
            const bool inside = triangles.slot(pair.first) == triangles.slot(pair.second);
            const std::uint32_t a = node_of(pair.first, inside), b = node_of(pair.second, inside);
            if (a != b) edges_.push_back({a, b, pair.same_facing});
        }
        aim_instances(pairs);
    }

    std::vector<Node>& nodes() { return nodes_; }

    /// Layers by the order of the source, opaque ones first.
    void choose_layers() {
        std::vector<std::uint32_t> order(nodes_.size()), rank(nodes_.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::tuple(nodes_[a].see_through, nodes_[a].first_triangle, a) <
                   std::tuple(nodes_[b].see_through, nodes_[b].first_triangle, b);
        });
        for (std::uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
        for (Edge& edge : edges_)
            if (rank[edge.from] > rank[edge.to]) std::swap(edge.from, edge.to);
        std::sort(edges_.begin(), edges_.end(), [&](const Edge& a, const Edge& b) {
            return std::tuple(rank[a.to], rank[a.from], a.same_facing) <
                   std::tuple(rank[b.to], rank[b.from], b.same_facing);
        });
        edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
        std::vector<int> taken;
        for (std::size_t begin = 0, end = 0; begin < edges_.size(); begin = end) {
            Node& node = nodes_[edges_[begin].to];
            taken.clear();
            int above_all = 0, above_opaque = 0;
            for (end = begin; end < edges_.size() && edges_[end].to == edges_[begin].to; ++end) {
                const Node& below = nodes_[edges_[end].from];
                // Back to back, it is enough that one of the two has left the plane.
                const int least = edges_[end].same_facing ? below.layer + 1 : below.layer == 0 ? 1 : 0;
                above_all = std::max(above_all, least);
                if (node.see_through && !below.see_through) above_opaque = std::max(above_opaque, least);
                if (edges_[end].same_facing || below.layer == 0) taken.push_back(below.layer);
            }
            node.layer = above_all;
            if (above_all <= kMostLayers) continue;
            node.layer = above_opaque;
            while (std::find(taken.begin(), taken.end(), node.layer) != taken.end()) ++node.layer;
        }
    }

    /// Turns layers into metres: one step for all that hangs together.
    void choose_offsets() {
        DisjointSets clusters(nodes_.size());
        for (const Edge& edge : edges_) clusters.unite(edge.from, edge.to);
        std::vector<double> step(nodes_.size(), kMostStepM), least(nodes_.size(), 0.0);
        std::vector<int> layers(nodes_.size(), 0);
        for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
            const std::uint32_t cluster = clusters.find(i);
            const Vec3 extent = nodes_[i].box.extent();
            step[cluster] = std::min(step[cluster], 0.01 * std::max({extent.x, extent.y, extent.z}));
            least[cluster] = std::max(least[cluster], nodes_[i].smallest_step);
            layers[cluster] = std::max(layers[cluster], nodes_[i].layer);
        }
        for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
            const std::uint32_t cluster = clusters.find(i);
            const double shrink = std::min(1.0, static_cast<double>(kMostLayers) / std::max(layers[cluster], 1));
            nodes_[i].patch.offset *= std::max(step[cluster] * shrink, least[cluster]) * nodes_[i].layer;
        }
    }

  private:
    void include(std::uint32_t index, std::uint32_t id) {
        Node& node = nodes_[index];
        const Corners corners = triangles_.corners(id);
        for (const DVec3& p : corners) node.box.add(Vec3(p));
        node.smallest_step = std::max(node.smallest_step, 2.0 * coincidence_tolerance(corners));
        node.see_through = node.see_through && is_see_through(materials_[triangles_.material(id)]);
        node.first_triangle = std::min(node.first_triangle, id);
    }

    std::uint32_t add_node(std::uint32_t id, bool whole_instance) {
        const DVec3 normal = glm::normalize(outward_area(triangles_, id));
        nodes_.push_back({.patch = {.slot = triangles_.slot(id),
                                    .whole_instance = whole_instance,
                                    .normal = normal,
                                    .offset = normal},
                          .first_triangle = id});
        return static_cast<std::uint32_t>(nodes_.size() - 1);
    }

    void make_patches(std::span<const CoincidentPair> pairs) {
        std::vector<std::uint32_t> ids;
        instances_.assign(triangles_.slots().size(), kNoPatch);
        for (const CoincidentPair& pair : pairs) {
            const bool inside = triangles_.slot(pair.first) == triangles_.slot(pair.second);
            for (const std::uint32_t id : {pair.first, pair.second}) {
                if (inside || !triangles_.slots()[triangles_.slot(id)].stays_whole) {
                    ids.push_back(id);
                    continue;
                }
                std::uint32_t& node = instances_[triangles_.slot(id)];
                if (node == kNoPatch) node = add_node(id, true);
                include(node, id);
            }
        }
        std::sort(ids.begin(), ids.end());
        ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
        const std::vector<std::uint32_t> groups = group_neighbours(triangles_, ids, pairs);
        for (std::uint32_t member = 0; member < ids.size(); ++member) {
            // The least member comes first, so its patch is there.
            patch_of_[ids[member]] =
                groups[member] == member ? add_node(ids[member], false) : patch_of_[ids[groups[member]]];
            include(patch_of_[ids[member]], ids[member]);
        }
    }

    [[nodiscard]] std::uint32_t node_of(std::uint32_t id, bool inside) const {
        const std::uint32_t slot = triangles_.slot(id);
        return !inside && triangles_.slots()[slot].stays_whole ? instances_[slot] : patch_of_[id];
    }

    /// An instance moves out of all planes that it shares, first that of the largest triangle.
    void aim_instances(std::span<const CoincidentPair> pairs) {
        struct Plane {
            std::uint32_t node;
            double minus_area;
            std::uint32_t triangle;
            DVec3 normal;
        };
        std::vector<Plane> planes;
        for (const CoincidentPair& pair : pairs) {
            if (triangles_.slot(pair.first) == triangles_.slot(pair.second)) continue;
            for (const std::uint32_t id : {pair.first, pair.second}) {
                if (!triangles_.slots()[triangles_.slot(id)].stays_whole) continue;
                const DVec3 area = outward_area(triangles_, id);
                planes.push_back({node_of(id, false), -glm::length(area), id, glm::normalize(area)});
            }
        }
        std::sort(planes.begin(), planes.end(), [](const Plane& a, const Plane& b) {
            return std::tie(a.node, a.minus_area, a.triangle) < std::tie(b.node, b.minus_area, b.triangle);
        });
        for (std::size_t i = 0; i < planes.size(); ++i) {
            CoincidentPatch& patch = nodes_[planes[i].node].patch;
            const bool first = i == 0 || planes[i - 1].node != planes[i].node;
            if (first)
                patch.normal = patch.offset = planes[i].normal;
            else if (std::abs(glm::dot(patch.offset, planes[i].normal)) < 0.5)
                patch.offset += planes[i].normal;
        }
    }

    const PlacedTriangles& triangles_;
    std::span<const scene::Material> materials_;
    std::vector<std::uint32_t>& patch_of_;
    std::vector<std::uint32_t> instances_;  // of each slot: its node
    std::vector<Node> nodes_;
    std::vector<Edge> edges_;
};

}  // namespace

CoincidentLayers order_coincident(const PlacedTriangles& triangles, std::span<const scene::Material> materials,
                                  std::span<const CoincidentPair> pairs) {
    CoincidentLayers layers;
    layers.patch_of.assign(triangles.size(), kNoPatch);
    Graph graph(triangles, materials, pairs, layers.patch_of);
    graph.choose_layers();
    graph.choose_offsets();
    for (const Node& node : graph.nodes()) layers.patches.push_back(node.patch);
    return layers;
}

}  // namespace ff::cook
