#include "engine/scene/world.h"

#include <algorithm>
#include <utility>

namespace ff::scene {

World::World(SceneData data, WorldInfo info) : data_(std::move(data)), info_(std::move(info)) {
    scene_ = data_.view();
    count();
    pose_room_ = add_pose_room(info_.animation, data_);
    const auto stored = std::uint32_t(scene_.meshes.size());
    scene_ = data_.view();
    scene_.posed_mesh_count = std::uint32_t(scene_.meshes.size()) - stored;
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
    for (const AnimatedInstance& instance : info_.animation.instances) {
        const AnimatedModel& model = info_.animation.models[instance.model];
        for (const RigidPart& part : model.parts)
            statistics_.instanced_triangles += scene_.meshes[part.mesh].triangle_count;
        for (const Skin& skin : model.skins) statistics_.instanced_triangles += scene_.meshes[skin.mesh].triangle_count;
    }
    const auto bytes = [](auto... arrays) { return (arrays.size_bytes() + ...); };
    statistics_.memory_bytes =
        bytes(scene_.positions, scene_.attributes, scene_.indices, scene_.triangle_materials, scene_.prelit_colors,
              scene_.meshes, scene_.instances, scene_.cells, scene_.materials, scene_.textures, scene_.texels,
              scene_.mesh_nodes, scene_.mesh_leaves, scene_.instance_nodes, scene_.height_grid.heights,
              scene_.environment.panorama);
}

}  // namespace ff::scene
