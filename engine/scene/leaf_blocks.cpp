#include "engine/scene/leaf_blocks.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <mutex>
#include <vector>

#include "engine/core/jobs.h"

namespace ff::scene {
namespace {

constexpr std::size_t kGrain = 1024;  // leaves a task

/// Leaves [begin, end) of all, all of one mesh; triangles counted within the mesh.
struct LeafRun {
    std::uint32_t mesh = 0;
    std::uint64_t begin = 0, end = 0;
    std::uint32_t first_triangle = 0;
};

/// Numbers corners' positions in the order of their first use. Vertices that follow each other are found by id in a
/// small table; only a vertex not seen lately is searched by its position, as prepare_mesh does: two vertices in one
/// place (a seam of uv or normals) are one here.
class CornerNumbers {
  public:
    explicit CornerNumbers(BvhLeaf& leaf) : leaf_(leaf) { std::memset(ids_, 0xFF, sizeof ids_); }

    /// The slot of a vertex, or -1 when all slots are taken by others.
    int slot_of(std::uint32_t vertex, const Vec3& p) {
        const std::uint32_t entry = vertex % kEntries;
        if (ids_[entry] == vertex) return slots_[entry];
        int slot = find(p);
        if (slot == count_) {
            if (count_ == BvhLeaf::kMaxVertices) return -1;
            leaf_.x[slot] = p.x;
            leaf_.y[slot] = p.y;
            leaf_.z[slot] = p.z;
            ++count_;
        }
        ids_[entry] = vertex;
        slots_[entry] = std::uint8_t(slot);
        return slot;
    }
    [[nodiscard]] int count() const { return count_; }

  private:
    static constexpr std::uint32_t kEntries = 64;

    [[nodiscard]] int find(const Vec3& p) const {
        const auto bits = [](float f) { return std::bit_cast<std::uint32_t>(f); };
        int slot = 0;
        while (slot < count_ && (bits(leaf_.x[slot]) != bits(p.x) || bits(leaf_.y[slot]) != bits(p.y) ||
                                 bits(leaf_.z[slot]) != bits(p.z)))
            ++slot;
        return slot;
    }

    BvhLeaf& leaf_;
    std::uint32_t ids_[kEntries];
    std::uint8_t slots_[kEntries];
    int count_ = 0;
};

/// Returns false where the triangles have too many vertices for a leaf. Writes every byte.
bool fill_leaf(const StaticScene& scene, const Mesh& mesh, std::uint32_t first_triangle, std::uint32_t count,
               BvhLeaf& leaf) {
    const std::size_t first = std::size_t(mesh.first_triangle) + first_triangle;
    std::memset(leaf.corner, 0, sizeof leaf.corner);
    leaf.first_triangle = first_triangle;
    leaf.triangle_count = std::uint16_t(count);
    std::memset(leaf.reserved, 0, sizeof leaf.reserved);
    unsigned alpha = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t flags = scene.materials[scene.triangle_materials[first + i]].flags;
        if (flags & (kMaterialAlphaMask | kMaterialBlend)) alpha |= 1u << i;
    }
    leaf.alpha_triangles = std::uint16_t(alpha);
    int vertices = 0;
    if (count <= BvhLeaf::kMaxDirect) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            for (std::uint32_t i = 0; i < BvhLeaf::kMaxDirect; ++i, ++vertices) {
                const std::size_t triangle = first + std::min(i, count - 1);
                const Vec3& p = scene.positions[mesh.first_vertex + std::size_t(scene.indices[3 * triangle + corner])];
                leaf.x[vertices] = p.x;
                leaf.y[vertices] = p.y;
                leaf.z[vertices] = p.z;
                if (i < count) leaf.corner[corner][i] = std::uint8_t(vertices);
            }
        }
    } else {
        CornerNumbers corners(leaf);
        for (std::uint32_t i = 0; i < count; ++i) {
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::uint32_t vertex = scene.indices[3 * (first + i) + corner];
                const int slot = corners.slot_of(vertex, scene.positions[mesh.first_vertex + std::size_t(vertex)]);
                if (slot < 0) return false;
                leaf.corner[corner][i] = std::uint8_t(slot);
            }
        }
        vertices = corners.count();
    }
    leaf.vertex_count = std::uint16_t(vertices);
    for (int i = vertices; i < BvhLeaf::kMaxVertices; ++i) {
        leaf.x[i] = leaf.x[vertices - 1];
        leaf.y[i] = leaf.y[vertices - 1];
        leaf.z[i] = leaf.z[vertices - 1];
    }
    return true;
}

class LeafRuns {
  public:
    LeafRuns(const StaticScene& scene, std::span<const std::uint8_t> sizes) : scene_(scene), sizes_(sizes) {}

    /// Calls take(leaf id, leaf) for each; take returns what is wrong with it, "" for nothing.
    /// @param place  the memory to fill for a leaf
    template <class Place, class Take>
    std::optional<WorldProblem> run(Place&& place, Take&& take) {
        if (!cut()) return problem_;
        parallel_for(runs_.size(), [&](std::size_t r) {
            const LeafRun& run = runs_[r];
            std::uint32_t triangle = run.first_triangle;
            BvhLeaf scratch;
            for (std::uint64_t id = run.begin; id < run.end; ++id) {
                BvhLeaf& leaf = place(id, scratch);
                if (!fill_leaf(scene_, scene_.meshes[run.mesh], triangle, sizes_[id], leaf)) {
                    report(id, fmt::format("{} triangles have over {} vertices; expected at most as many", sizes_[id],
                                           BvhLeaf::kMaxVertices));
                    return;
                }
                if (std::string what = take(id, leaf); !what.empty()) {
                    report(id, std::move(what));
                    return;
                }
                triangle += sizes_[id];
            }
        });
        return problem_;
    }

  private:
    bool report(std::uint64_t id, std::string what) {
        const std::scoped_lock lock(mutex_);
        if (!problem_ || id < problem_->element) problem_ = {"mesh_leaves", id, std::move(what)};
        return false;
    }

    bool cut() {
        for (std::uint32_t m = 0; m < scene_.meshes.size(); ++m) {
            const Mesh& mesh = scene_.meshes[m];
            const std::uint64_t last = std::uint64_t(mesh.first_leaf) + mesh.leaf_count;
            std::uint64_t triangle = 0;
            for (std::uint64_t begin = mesh.first_leaf; begin < last;) {
                const std::uint64_t end = std::min(last, begin + kGrain);
                runs_.push_back({m, begin, end, std::uint32_t(triangle)});
                for (; begin < end; ++begin) {
                    if (sizes_[begin] < 1 || sizes_[begin] > BvhLeaf::kMaxTriangles)
                        return report(begin, fmt::format("{} triangles; expected 1 to {}", sizes_[begin],
                                                         BvhLeaf::kMaxTriangles));
                    triangle += sizes_[begin];
                }
                if (triangle > mesh.triangle_count) break;
            }
            if (triangle != mesh.triangle_count)
                return report(mesh.first_leaf, fmt::format("the leaves of mesh {} do not hold its {} triangles", m,
                                                           mesh.triangle_count));
        }
        return true;
    }

    const StaticScene& scene_;
    std::span<const std::uint8_t> sizes_;
    std::vector<LeafRun> runs_;
    std::mutex mutex_;
    std::optional<WorldProblem> problem_;
};

}  // namespace

std::optional<WorldProblem> make_leaf_blocks(const StaticScene& scene, std::span<const std::uint8_t> leaf_sizes,
                                             std::span<BvhLeaf> leaves) {
    return LeafRuns(scene, leaf_sizes)
        .run([&](std::uint64_t id, BvhLeaf&) -> BvhLeaf& { return leaves[id]; },
             [](std::uint64_t, const BvhLeaf&) { return std::string(); });
}

std::optional<WorldProblem> compare_leaf_blocks(const StaticScene& scene, std::span<const std::uint8_t> leaf_sizes) {
    return LeafRuns(scene, leaf_sizes)
        .run([](std::uint64_t, BvhLeaf& scratch) -> BvhLeaf& { return scratch; },
             [&](std::uint64_t id, const BvhLeaf& leaf) {
                 return std::memcmp(&leaf, &scene.mesh_leaves[id], sizeof leaf) == 0
                            ? std::string()
                            : std::string("does not hold the mesh's triangles in their order; expected prepare_mesh's");
             });
}

}  // namespace ff::scene
