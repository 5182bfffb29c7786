#pragma once
// Where in a scene's hierarchies its blended triangles are, so that a search for transparent layers goes nowhere else.

#include <cstdint>
#include <vector>

#include "engine/core/zero_pages.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

/// Bits by child or triangle, parallel to the scene's arrays; all empty for a scene without blended materials. What
/// belongs to meshes without any is never touched and takes no memory.
struct LayerIndex {
    ZeroPageVector<std::uint16_t> mesh_children;   ///< of mesh_nodes: children with blended triangles under them
    ZeroPageVector<std::uint16_t> leaf_triangles;  ///< of mesh_leaves: triangles that are blended
    std::vector<std::uint16_t> instance_children;  ///< of instance_nodes: children with such instances under them

    [[nodiscard]] bool is_empty() const { return mesh_children.empty(); }
    [[nodiscard]] std::uint64_t memory_bytes() const {
        return 2 * (mesh_children.size() + leaf_triangles.size() + instance_children.size());
    }
};

[[nodiscard]] LayerIndex make_layer_index(const scene::StaticScene& scene);

/// Whether some instance with blended triangles may reach that near: by its box, conservatively.
[[nodiscard]] bool has_layers_within(const scene::StaticScene& scene, const LayerIndex& index, const WorldPos& eye,
                                     double within_m);

}  // namespace ff::farfield
