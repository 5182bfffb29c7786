#pragma once
// A static scene in the GPU's memory: vertices as they are, triangles by material, textures with their mips.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/result.h"
#include "engine/gl/buffer.h"
#include "engine/gl/texture.h"
#include "engine/nearfield/mesh_layout.h"
#include "engine/scene/static_scene.h"

namespace ff::nearfield {

struct GpuScene {
    SceneLayout layout;
    gl::Buffer positions;       ///< Vec3
    gl::Buffer attributes;      ///< scene::VertexAttributes
    gl::Buffer indices;         ///< 32 bits, relative to the mesh's first vertex, triangles in GPU order
    gl::Buffer triangle_names;  ///< layout.reordered; read where triangles are blended
    std::vector<gl::Texture> textures;
    bool has_vertex_colors = false;  ///< some vertex is not white

    [[nodiscard]] std::uint64_t memory_bytes(const scene::StaticScene& scene) const;
};

/// Uploads a scene. The triangles are put in order a piece at a time, so there is never a second copy of them.
/// Errors: the GPU has no room, or takes no texture of such a size.
Result<GpuScene> upload_scene(const scene::StaticScene& scene);

}  // namespace ff::nearfield
