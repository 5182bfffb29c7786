// A mesh put into the order of its hierarchy, and the leaf blocks that the casters read.

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "engine/core/jobs.h"
#include "engine/scene/bvh_builder.h"
#include "engine/scene/scene_data.h"

namespace ff::scene {
namespace {

// Positions of the corners of a few triangles without repetition.
class LeafVertices {
  public:
    // The slot of a position, or -1 when all slots are taken by others.
    int slot_of(const Vec3& p) {
        for (int i = 0; i < count_; ++i) {
            if (std::memcmp(&positions_[i], &p, sizeof p) == 0) return i;
        }
        if (count_ == BvhLeaf::kMaxVertices) return -1;
        positions_[count_] = p;
        return count_++;
    }
    [[nodiscard]] int count() const { return count_; }
    [[nodiscard]] const Vec3& operator[](int i) const { return positions_[i]; }

  private:
    Vec3 positions_[BvhLeaf::kMaxVertices];
    int count_ = 0;
};

Vec3 corner_position(const MeshSource& mesh, std::size_t triangle, int corner) {
    return mesh.positions[mesh.indices[3 * triangle + std::size_t(corner)]];
}

// Beyond BvhLeaf::kMaxDirect triangles they have to share vertices well enough: else two leaves serve better than one.
bool vertices_fit(const MeshSource& mesh, std::span<const BuildPrimitive> triangles) {
    if (triangles.size() <= BvhLeaf::kMaxDirect) return true;
    LeafVertices vertices;
    for (const BuildPrimitive& triangle : triangles) {
        for (int corner = 0; corner < 3; ++corner) {
            if (vertices.slot_of(corner_position(mesh, triangle.id, corner)) < 0) return false;
        }
    }
    return std::size_t(vertices.count()) <= 2 * triangles.size();
}

// How many triangles of this mesh usually go into a leaf: all where they share vertices well, else as many as need not
// share any. A number that many leaves cannot hold would make the builder peel single triangles off until one fits.
std::uint32_t usual_leaf_triangles(const MeshSource& mesh) {
    constexpr std::size_t kComfortable = BvhLeaf::kMaxTriangles * 3 / 2;
    std::vector<Vec3> positions = mesh.positions;
    const auto before = [](const Vec3& a, const Vec3& b) { return std::memcmp(&a, &b, sizeof a) < 0; };
    std::sort(positions.begin(), positions.end(), before);
    const auto same = [](const Vec3& a, const Vec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; };
    const auto distinct = std::size_t(std::unique(positions.begin(), positions.end(), same) - positions.begin());
    const bool all_fit = BvhLeaf::kMaxVertices * (mesh.indices.size() / 3) >= kComfortable * distinct;
    return all_fit ? BvhLeaf::kMaxTriangles : BvhLeaf::kMaxDirect;
}

// Numbers equal vertices alike, in the order of their first use by `triangles`, and rewrites the mesh so.
class VertexReorder {
  public:
    explicit VertexReorder(MeshSource& mesh) : mesh_(mesh) {
        std::size_t slots = 16;
        while (slots < 2 * mesh.positions.size()) slots *= 2;
        table_.assign(slots, kUnused);
    }

    void run(std::span<const BuildPrimitive> triangles) {
        MeshSource out;
        out.indices.reserve(3 * triangles.size());
        out.triangle_materials.reserve(triangles.size());
        out.positions.reserve(mesh_.positions.size());
        out.attributes.reserve(mesh_.positions.size());
        std::vector<std::uint32_t> new_id(mesh_.positions.size(), kUnused);
        for (const BuildPrimitive& triangle : triangles) {
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::uint32_t old = mesh_.indices[3 * triangle.id + corner];
                if (new_id[old] == kUnused) new_id[old] = find_or_add(old, out);
                out.indices.push_back(new_id[old]);
            }
            out.triangle_materials.push_back(mesh_.triangle_materials[triangle.id]);
        }
        mesh_ = std::move(out);
    }

  private:
    static constexpr std::uint32_t kUnused = 0xFFFFFFFFu;

    std::uint32_t find_or_add(std::uint32_t old, MeshSource& out) {
        struct Key {
            Vec3 position;
            VertexAttributes attributes;
        } key{mesh_.positions[old], mesh_.attributes[old]};
        static_assert(sizeof(Key) == 28);
        const std::size_t mask = table_.size() - 1;
        for (std::size_t slot = hash_bytes(std::as_bytes(std::span(&key, 1))) & mask;; slot = (slot + 1) & mask) {
            const std::uint32_t id = table_[slot];
            if (id == kUnused) {
                table_[slot] = std::uint32_t(out.positions.size());
                out.positions.push_back(key.position);
                out.attributes.push_back(key.attributes);
                return table_[slot];
            }
            if (std::memcmp(&out.positions[id], &key.position, sizeof key.position) == 0 &&
                std::memcmp(&out.attributes[id], &key.attributes, sizeof key.attributes) == 0) {
                return id;
            }
        }
    }

    MeshSource& mesh_;
    std::vector<std::uint32_t> table_;
};

void fill_direct(const MeshSource& mesh, BvhLeaf& leaf) {
    leaf.vertex_count = 3 * BvhLeaf::kMaxDirect;
    for (int corner = 0; corner < 3; ++corner) {
        for (int i = 0; i < BvhLeaf::kMaxDirect; ++i) {
            const int slot = corner * BvhLeaf::kMaxDirect + i, triangle = std::min(i, leaf.triangle_count - 1);
            const Vec3 p = corner_position(mesh, leaf.first_triangle + std::size_t(triangle), corner);
            leaf.x[slot] = p.x;
            leaf.y[slot] = p.y;
            leaf.z[slot] = p.z;
            if (i < leaf.triangle_count) leaf.corner[corner][i] = std::uint8_t(slot);
        }
    }
}

void fill_shared(const MeshSource& mesh, BvhLeaf& leaf) {
    LeafVertices vertices;
    for (int i = 0; i < leaf.triangle_count; ++i) {
        for (int corner = 0; corner < 3; ++corner) {
            const Vec3 p = corner_position(mesh, leaf.first_triangle + std::size_t(i), corner);
            leaf.corner[corner][i] = std::uint8_t(vertices.slot_of(p));
        }
    }
    leaf.vertex_count = std::uint16_t(vertices.count());
    for (int i = 0; i < vertices.count(); ++i) {
        leaf.x[i] = vertices[i].x;
        leaf.y[i] = vertices[i].y;
        leaf.z[i] = vertices[i].z;
    }
}

BvhLeaf make_leaf(const MeshSource& mesh, const LeafRange& range, std::span<const Material> materials) {
    BvhLeaf leaf{};
    leaf.first_triangle = range.first;
    leaf.triangle_count = std::uint16_t(range.count);
    if (range.count <= BvhLeaf::kMaxDirect)
        fill_direct(mesh, leaf);
    else
        fill_shared(mesh, leaf);
    for (int i = leaf.vertex_count; i < BvhLeaf::kMaxVertices; ++i) {
        leaf.x[i] = leaf.x[leaf.vertex_count - 1];
        leaf.y[i] = leaf.y[leaf.vertex_count - 1];
        leaf.z[i] = leaf.z[leaf.vertex_count - 1];
    }
    for (std::uint32_t i = 0; i < range.count; ++i) {
        const Material& material = materials[mesh.triangle_materials[range.first + i]];
        if (material.flags & (kMaterialAlphaMask | kMaterialBlend))
            leaf.alpha_triangles = std::uint16_t(leaf.alpha_triangles | (1u << i));
    }
    return leaf;
}

}  // namespace

PreparedMesh prepare_mesh(MeshSource source, std::span<const Material> materials) {
    const std::size_t triangle_count = source.indices.size() / 3;
    FF_CHECK(source.indices.size() % 3 == 0, "{} indices", source.indices.size());
    FF_CHECK(source.attributes.size() == source.positions.size(), "{} attributes, {} positions",
             source.attributes.size(), source.positions.size());
    FF_CHECK(source.triangle_materials.size() == triangle_count, "{} materials, {} triangles",
             source.triangle_materials.size(), triangle_count);
    for (const std::uint32_t index : source.indices)
        FF_CHECK(index < source.positions.size(), "vertex {} of {}", index, source.positions.size());
    for (const std::uint16_t material : source.triangle_materials)
        FF_CHECK(material < materials.size(), "material {} of {}", material, materials.size());

    PreparedMesh out;
    std::vector<BuildPrimitive> triangles(triangle_count);
    for (std::size_t i = 0; i < triangle_count; ++i) {
        triangles[i].id = std::uint32_t(i);
        for (int corner = 0; corner < 3; ++corner) triangles[i].box.add(corner_position(source, i, corner));
        out.bounds.add(triangles[i].box);
        out.material_flags |= materials[source.triangle_materials[i]].flags;
    }
    const LeafFits fits = [&](std::span<const BuildPrimitive> range) { return vertices_fit(source, range); };
    WideBvh bvh = build_wide_bvh(triangles, {.usual_leaf_primitives = usual_leaf_triangles(source)}, fits);
    VertexReorder(source).run(triangles);
    out.leaves.resize(bvh.leaves.size());
    parallel_ranges(bvh.leaves.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) out.leaves[i] = make_leaf(source, bvh.leaves[i], materials);
    });
    out.nodes = std::move(bvh.nodes);
    out.geometry = std::move(source);
    return out;
}

}  // namespace ff::scene
