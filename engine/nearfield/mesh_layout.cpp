#include "engine/nearfield/mesh_layout.h"

#include <algorithm>

#include "engine/core/jobs.h"

namespace ff::nearfield {

MaterialLayer layer_of(const scene::Material& material) {
    if (material.flags & scene::kMaterialBlend) return MaterialLayer::blended;
    if (material.flags & scene::kMaterialAlphaMask) return MaterialLayer::masked;
    return MaterialLayer::opaque;
}

namespace {

/// The groups of one mesh, without triangle order: what a counting sort by material finds in its first pass.
void count_groups(std::span<const std::uint16_t> materials, std::span<const scene::Material> all,
                  std::vector<MaterialGroup>& groups) {
    groups.clear();
    std::vector<std::uint32_t> slot_of(all.size(), ~0u);
    for (std::uint16_t material : materials) {
        std::uint32_t& slot = slot_of[material];
        if (slot == ~0u) {
            slot = std::uint32_t(groups.size());
            groups.push_back({.material = material});
        }
        ++groups[slot].triangle_count;
    }
    std::sort(groups.begin(), groups.end(), [&](const MaterialGroup& a, const MaterialGroup& b) {
        const MaterialLayer la = layer_of(all[a.material]), lb = layer_of(all[b.material]);
        return la != lb ? la < lb : a.material < b.material;
    });
    std::uint32_t first = 0;
    for (MaterialGroup& group : groups) {
        group.first_triangle = first;
        first += group.triangle_count;
    }
}

}  // namespace

SceneLayout make_layout(const scene::StaticScene& scene) {
    SceneLayout layout;
    layout.meshes.resize(scene.meshes.size());
    std::vector<std::vector<MaterialGroup>> groups(scene.meshes.size());
    const auto materials_of = [&](const scene::Mesh& mesh) {
        return scene.triangle_materials.subspan(mesh.first_triangle, mesh.triangle_count);
    };
    parallel_for(scene.meshes.size(),
                 [&](std::size_t m) { count_groups(materials_of(scene.meshes[m]), scene.materials, groups[m]); });

    std::uint32_t reordered_count = 0;
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        MeshLayout& mesh = layout.meshes[m];
        mesh.first_group = std::uint32_t(layout.groups.size());
        mesh.group_count = std::uint32_t(groups[m].size());
        for (const MaterialGroup& group : groups[m]) {
            if (layer_of(scene.materials[group.material]) != MaterialLayer::opaque) continue;
            ++mesh.opaque_group_count;
            mesh.opaque_triangle_count += group.triangle_count;
        }
        layout.groups.insert(layout.groups.end(), groups[m].begin(), groups[m].end());
        if (mesh.group_count > 1) {
            mesh.first_reordered = reordered_count;
            reordered_count += scene.meshes[m].triangle_count;
        }
    }

    layout.reordered.resize(reordered_count);
    parallel_for(scene.meshes.size(), [&](std::size_t m) {
        const MeshLayout& mesh = layout.meshes[m];
        if (mesh.first_reordered == MeshLayout::kSceneOrder) return;
        std::vector<std::uint32_t> next(scene.materials.size());
        for (const MaterialGroup& group : groups[m]) next[group.material] = mesh.first_reordered + group.first_triangle;
        const auto materials = materials_of(scene.meshes[m]);
        for (std::uint32_t t = 0; t < materials.size(); ++t) layout.reordered[next[materials[t]]++] = t;
    });
    return layout;
}

}  // namespace ff::nearfield
