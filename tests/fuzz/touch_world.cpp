#include "tests/fuzz/touch_world.h"

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "engine/core/check.h"
#include "engine/scene/check_world.h"
#include "engine/scene/texel_address.h"

namespace ff::test {
namespace {

using namespace scene;

template <class T>
const T& at(std::span<const T> array, std::uint64_t i) {
    FF_CHECK(i < array.size(), "element {} of {}", i, array.size());
    return array[i];
}

class Toucher {
  public:
    explicit Toucher(const World& world) : world_(world), s_(world.scene()), mesh_done_(s_.meshes.size()) {}

    double run() {
        tree(s_.instance_nodes, 0, s_.instances.size(), [&](std::uint32_t id) { instance(at(s_.instances, id)); });
        for (const Cell& cell : s_.cells)
            for (std::uint64_t i = 0; i < cell.instance_count; ++i)
                instance(at(s_.instances, std::uint64_t(cell.first_instance) + i));
        for (const DynamicInstance& dynamic : world_.info().dynamic_instances) mesh(dynamic.mesh);
        for (const AnimatedModel& model : world_.info().animation.models) {
            for (const RigidPart& part : model.parts) mesh(part.mesh);
            for (const Skin& skin : model.skins) mesh(skin.mesh);
        }
        for (const Walk& walk : world_.info().walks)
            for (std::size_t i = 0; i < walk.frames.size(); ++i) add(walk.camera(i).position.x);
        std::uint64_t first = 0;
        for (std::uint64_t size = s_.height_grid.size; size > 0; size /= 2) {
            first += size * size;
            at(s_.height_grid.heights, first - 1);
        }
        return sum_;
    }

  private:
    void add(double value) {
        FF_CHECK(std::isfinite(value), "{}", value);
        sum_ += value;
    }

    // With a stack as small as the casters' own.
    template <class Leaf>
    void tree(std::span<const BvhNode> nodes, std::uint64_t first_node, std::uint64_t leaf_limit, Leaf&& leaf) {
        if (nodes.empty()) return;
        std::array<std::uint32_t, kBvhWidth * kMaxBvhDepth> stack{};
        std::size_t top = 0;
        stack[top++] = 0;
        std::uint64_t visits = 0;
        while (top > 0) {
            const BvhNode& node = at(nodes, first_node + stack[--top]);
            FF_CHECK(++visits <= nodes.size(), "{} visits", visits);
            for (int lane = 0; lane < kBvhWidth; ++lane) {
                const std::uint32_t child = node.child[lane];
                if (child == kBvhEmpty) {
                    FF_CHECK(node.low_x[lane] > node.high_x[lane], "an empty lane can be hit");
                    continue;
                }
                add(double(node.low_x[lane]) + node.high_z[lane]);
                if ((child & kBvhLeafBit) != 0) {
                    FF_CHECK((child & ~kBvhLeafBit) < leaf_limit, "leaf {}", child);
                    leaf(child & ~kBvhLeafBit);
                } else {
                    FF_CHECK(top < stack.size(), "stack");
                    stack[top++] = child;
                }
            }
        }
    }

    void instance(const Instance& i) {
        add(i.position.x + double(i.world_from_mesh[2].z));
        at(s_.cells, i.cell);
        mesh(i.mesh);
    }

    void mesh(std::uint32_t id) {
        const Mesh& m = at(s_.meshes, id);
        if (mesh_done_[id] != 0) return;
        mesh_done_[id] = 1;
        if (m.node_count == 0) return;
        tree(s_.mesh_nodes, m.first_node, m.leaf_count,
             [&](std::uint32_t leaf_id) { leaf(m, at(s_.mesh_leaves, std::uint64_t(m.first_leaf) + leaf_id)); });
        for (std::uint64_t t = 0; t < m.triangle_count; ++t) triangle(m, t);
    }

    void leaf(const Mesh& m, const BvhLeaf& l) {
        FF_CHECK(l.triangle_count >= 1 && l.triangle_count <= BvhLeaf::kMaxTriangles, "{}", l.triangle_count);
        FF_CHECK(std::uint64_t(l.first_triangle) + l.triangle_count <= m.triangle_count, "{}", l.first_triangle);
        for (int v = 0; v < BvhLeaf::kMaxVertices; ++v) add(double(l.x[v]) + l.y[v] + l.z[v]);
        for (int t = 0; t < BvhLeaf::kMaxTriangles; ++t)
            for (int c = 0; c < 3; ++c) FF_CHECK(l.corner[c][t] < BvhLeaf::kMaxVertices, "{}", l.corner[c][t]);
    }

    void triangle(const Mesh& m, std::uint64_t t) {
        const std::uint64_t id = m.first_triangle + t;
        const Material& material = at(s_.materials, at(s_.triangle_materials, id));
        add(at(s_.prelit_colors, id) & 0xFF);
        for (std::uint64_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t index = at(s_.indices, 3 * id + corner);
            FF_CHECK(index < m.vertex_count, "{}", index);
            const Vec3& p = at(s_.positions, std::uint64_t(m.first_vertex) + index);
            add(double(p.x) + p.y + p.z);
            const VertexAttributes& a = at(s_.attributes, std::uint64_t(m.first_vertex) + index);
            for (const std::uint32_t texture :
                 {material.base_color_texture, material.emissive_texture, material.metallic_roughness_texture})
                if (texture != kNoTexture) texels(at(s_.textures, texture), a.uv);
        }
    }

    void texels(const Texture& texture, const Vec2& uv) {
        for (std::uint32_t level = 0; level < texture.level_count; ++level)
            add(at(s_.texels, texel_index(texture, uv, level)) & 0xFF);
    }

    const World& world_;
    const StaticScene& s_;
    std::vector<std::uint8_t> mesh_done_;
    double sum_ = 0;
};

}  // namespace

double touch_world(const scene::World& world) {
    return Toucher(world).run();
}

}  // namespace ff::test
