#include "engine/scene/world.h"

#include <algorithm>
#include <utility>

namespace ff::scene {

World::World(SceneData data, WorldInfo info) : data_(std::move(data)), scene_(data_.view()), info_(std::move(info)) {
    count();
}

const NamedPlace* World::find_place(std::string_view name) const {
    for (const NamedPlace& place : info_.places)
        if (place.name == name) return &place;
    return nullptr;
}

const Walk* World::find_walk(std::string_view name) const {
    const auto found =
        std::find_if(info_.walks.begin(), info_.walks.end(), [&](const Walk& walk) { return walk.name == name; });
    return found == info_.walks.end() ? nullptr : &*found;
}

void World::count() {
    statistics_.triangles = scene_.triangle_materials.size();
    statistics_.vertices = scene_.positions.size();
    for (const Cell& cell : scene_.cells) statistics_.instanced_triangles += cell.triangle_count;
    for (const DynamicInstance& instance : info_.dynamic_instances)
        statistics_.instanced_triangles += scene_.meshes[instance.mesh].triangle_count;
    const auto bytes = [](auto... arrays) { return (arrays.size_bytes() + ...); };
    statistics_.memory_bytes =
        bytes(scene_.positions, scene_.attributes, scene_.indices, scene_.triangle_materials, scene_.prelit_colors,
              scene_.meshes, scene_.instances, scene_.cells, scene_.materials, scene_.textures, scene_.texels,
              scene_.mesh_nodes, scene_.mesh_leaves, scene_.instance_nodes, scene_.height_grid.heights,
              scene_.environment.panorama);
}

}  // namespace ff::scene
