#pragma once
// The order in which the GPU holds triangles: by material within each mesh, so that a draw has one material and one set
// of textures (llvmpipe pays for every sampler that a shader could reach). Visible points keep the scene's own names:
// triangle_of() translates.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene/static_scene.h"

namespace ff::nearfield {

enum class MaterialLayer : std::uint8_t { opaque, masked, blended };

[[nodiscard]] MaterialLayer layer_of(const scene::Material& material);

/// Consecutive triangles of a mesh, in GPU order, that share a material.
struct MaterialGroup {
    std::uint32_t material = 0;
    std::uint32_t first_triangle = 0;  ///< within the mesh, GPU order
    std::uint32_t triangle_count = 0;
};

struct MeshLayout {
    std::uint32_t first_group = 0, group_count = 0;  ///< opaque groups first, then masked, then blended
    std::uint32_t opaque_group_count = 0;
    std::uint32_t opaque_triangle_count = 0;           ///< the first so many triangles, GPU order
    std::uint32_t first_reordered = kSceneOrder;       ///< of SceneLayout::reordered
    static constexpr std::uint32_t kSceneOrder = ~0u;  ///< the mesh has one material: nothing moved
};

struct SceneLayout {
    std::vector<MeshLayout> meshes;
    std::vector<MaterialGroup> groups;
    std::vector<std::uint32_t> reordered;  ///< triangle in the scene's order, by GPU order; only meshes that need it

    /// The scene's name of a triangle that the GPU calls `gpu_triangle`, both within the mesh.
    [[nodiscard]] std::uint32_t triangle_of(std::uint32_t mesh, std::uint32_t gpu_triangle) const {
        const std::uint32_t first = meshes[mesh].first_reordered;
        return first == MeshLayout::kSceneOrder ? gpu_triangle : reordered[first + gpu_triangle];
    }
};

/// Sorts each mesh's triangles by layer and material, stably. Parallel over meshes; the same for any number of workers.
[[nodiscard]] SceneLayout make_layout(const scene::StaticScene& scene);

}  // namespace ff::nearfield
