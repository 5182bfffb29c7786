#include "engine/scene/scene_data.h"

#include <algorithm>
#include <cmath>

#include "engine/core/check.h"
#include "engine/scene/instance_bounds.h"
#include "engine/scene/prelit_colors.h"
#include "engine/scene/texture_mips.h"

namespace ff::scene {
namespace {

template <class T>
std::uint32_t append(std::vector<T>& to, const std::vector<T>& from) {
    const std::size_t first = to.size();
    FF_CHECK(first + from.size() <= 0xFFFFFFFFu, "{} elements", first + from.size());
    to.insert(to.end(), from.begin(), from.end());
    return std::uint32_t(first);
}

// Tighter than the box of the mesh's box, where the instance is rotated: the root's children bound it from within.
DBox3 bounds_of(const SceneData& scene, const Instance& instance) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    DBox3 out;
    if (mesh.node_count == 0) return out;
    const BvhNode& root = scene.mesh_nodes[mesh.first_node];
    for (int lane = 0; lane < kBvhWidth; ++lane) {
        if (root.child[lane] == kBvhEmpty) continue;
        out.add(world_box(instance, Box3{Vec3(root.low_x[lane], root.low_y[lane], root.low_z[lane]),
                                         Vec3(root.high_x[lane], root.high_y[lane], root.high_z[lane])}));
    }
    return out;
}

}  // namespace

std::uint32_t SceneData::add_texture(std::span<const std::uint32_t> rgba, std::uint32_t width, std::uint32_t height,
                                     Wrap wrap_u, Wrap wrap_v) {
    Texture texture = append_mip_chain(rgba, width, height, texels);
    texture.wrap_u = wrap_u;
    texture.wrap_v = wrap_v;
    textures.push_back(texture);
    return std::uint32_t(textures.size() - 1);
}

std::uint32_t SceneData::add_mesh(PreparedMesh mesh) {
    Mesh entry;
    entry.vertex_count = std::uint32_t(mesh.geometry.positions.size());
    entry.triangle_count = std::uint32_t(mesh.geometry.triangle_materials.size());
    entry.node_count = std::uint32_t(mesh.nodes.size());
    entry.leaf_count = std::uint32_t(mesh.leaves.size());
    entry.bounds = mesh.bounds;
    entry.material_flags = mesh.material_flags;
    entry.first_vertex = append(positions, mesh.geometry.positions);
    append(attributes, mesh.geometry.attributes);
    entry.first_triangle = append(triangle_materials, mesh.geometry.triangle_materials);
    indices.insert(indices.end(), mesh.geometry.indices.begin(), mesh.geometry.indices.end());
    entry.first_node = append(mesh_nodes, mesh.nodes);
    entry.first_leaf = append(mesh_leaves, mesh.leaves);
    meshes.push_back(entry);
    return std::uint32_t(meshes.size() - 1);
}

std::uint32_t SceneData::add_instance(std::uint32_t mesh, const WorldPos& position, const Mat3& world_from_mesh,
                                      std::uint32_t cell) {
    FF_CHECK(mesh < meshes.size(), "mesh {} of {}", mesh, meshes.size());
    instances.push_back({.position = position, .world_from_mesh = world_from_mesh, .mesh = mesh, .cell = cell});
    return std::uint32_t(instances.size() - 1);
}

void SceneData::finish(std::uint32_t height_grid_size) {
    std::stable_sort(instances.begin(), instances.end(),
                     [](const Instance& a, const Instance& b) { return a.cell < b.cell; });
    cells.clear();
    bounds = DBox3{};
    std::uint32_t callers_cell = 0;
    for (std::size_t i = 0; i < instances.size(); ++i) {
        Instance& instance = instances[i];
        if (cells.empty() || instance.cell != callers_cell) {
            callers_cell = instance.cell;
            cells.push_back({.first_instance = std::uint32_t(i)});
        }
        instance.cell = std::uint32_t(cells.size() - 1);
        instance.bounds = bounds_of(*this, instance);
        Cell& cell = cells.back();
        cell.bounds.add(instance.bounds);
        ++cell.instance_count;
        cell.triangle_count += meshes[instance.mesh].triangle_count;
    }
    for (Cell& cell : cells) {
        if (!cell.bounds.is_empty()) cell.origin = glm::round(cell.bounds.center());
        bounds.add(cell.bounds);
    }
    origin = bounds.is_empty() ? WorldPos(0.0) : glm::round(bounds.center());
    build_instance_bvh(instances, origin, instance_nodes);
    prelit_colors = make_prelit_colors(*this);
    if (height_grid_size != 0) build_height_grid(*this, height_grid_size, height_grid, heights);
}

StaticScene SceneData::view() const {
    StaticScene scene{.origin = origin,
                      .bounds = bounds,
                      .positions = positions,
                      .attributes = attributes,
                      .indices = indices,
                      .triangle_materials = triangle_materials,
                      .prelit_colors = prelit_colors,
                      .meshes = meshes,
                      .instances = instances,
                      .cells = cells,
                      .materials = materials,
                      .textures = textures,
                      .texels = texels,
                      .mesh_nodes = mesh_nodes,
                      .mesh_leaves = mesh_leaves,
                      .instance_nodes = instance_nodes,
                      .height_grid = height_grid,
                      .environment = environment,
                      .lamps = lamps};
    scene.height_grid.heights = heights;
    scene.environment.panorama = sky_panorama;
    return scene;
}

}  // namespace ff::scene
