#include "engine/nearfield/gpu_scene.h"

#include <algorithm>
#include <cstring>

#include "engine/core/log.h"
#include "engine/scene/texel_address.h"

namespace ff::nearfield {
namespace {

GLenum gl_wrap(scene::Wrap wrap) {
    switch (wrap) {
        case scene::Wrap::repeat:
            return GL_REPEAT;
        case scene::Wrap::clamp:
            return GL_CLAMP_TO_EDGE;
        case scene::Wrap::mirror:
            return GL_MIRRORED_REPEAT;
    }
    return GL_REPEAT;
}

Result<gl::Texture> upload_texture(const scene::StaticScene& scene, const scene::Texture& texture) {
    // Not an sRGB format: the shading model filters texels as they are encoded and decodes afterwards.
    FF_ASSIGN(gl::Texture out,
              gl::Texture::make(GL_RGBA8, int(texture.width), int(texture.height), int(texture.level_count)));
    for (std::uint32_t level = 0; level < texture.level_count; ++level) {
        const std::size_t first = texture.first_texel + scene::level_offset(texture, level);
        const std::size_t count =
            std::size_t(std::max(1u, texture.width >> level)) * std::max(1u, texture.height >> level);
        out.write_level(int(level), GL_RGBA, GL_UNSIGNED_BYTE, std::as_bytes(scene.texels.subspan(first, count)));
    }
    out.set_wrap(gl_wrap(texture.wrap_u), gl_wrap(texture.wrap_v));
    out.set_filter(GL_LINEAR_MIPMAP_NEAREST, GL_LINEAR);
    return out;
}

/// Indices of all meshes; those that were reordered are gathered piece by piece.
void write_indices(const scene::StaticScene& scene, const SceneLayout& layout, gl::Buffer& out, Progress& progress) {
    constexpr std::uint32_t kPieceTriangles = 1u << 18;
    std::vector<std::uint32_t> piece(3 * kPieceTriangles);
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const scene::Mesh& mesh = scene.meshes[m];
        const std::uint32_t first_reordered = layout.meshes[m].first_reordered;
        const std::uint32_t* source = scene.indices.data() + 3 * std::size_t(mesh.first_triangle);
        for (std::uint32_t begin = 0; begin < mesh.triangle_count; begin += kPieceTriangles) {
            const std::uint32_t count = std::min(kPieceTriangles, mesh.triangle_count - begin);
            std::span<const std::uint32_t> indices(source + 3 * std::size_t(begin), 3 * std::size_t(count));
            if (first_reordered != MeshLayout::kSceneOrder) {
                for (std::uint32_t t = 0; t < count; ++t)
                    std::memcpy(&piece[3 * std::size_t(t)],
                                source + 3 * std::size_t(layout.reordered[first_reordered + begin + t]), 12);
                indices = {piece.data(), 3 * std::size_t(count)};
            }
            out.write(12 * (std::uint64_t(mesh.first_triangle) + begin), std::as_bytes(indices));
            progress.advance(count);
        }
    }
}

}  // namespace

std::uint64_t GpuScene::memory_bytes(const scene::StaticScene& scene) const {
    return positions.size_bytes() + attributes.size_bytes() + indices.size_bytes() + triangle_names.size_bytes() +
           scene.texels.size_bytes();
}

Result<GpuScene> upload_scene(const scene::StaticScene& scene) {
    GpuScene gpu;
    Progress progress("uploading to OpenGL", scene.indices.size() / 3 + scene.textures.size());
    gpu.layout = make_layout(scene);
    FF_ASSIGN(gpu.positions, gl::Buffer::make(scene.positions.size_bytes()));
    gpu.positions.write(0, std::as_bytes(scene.positions));
    FF_ASSIGN(gpu.attributes, gl::Buffer::make(scene.attributes.size_bytes()));
    gpu.attributes.write(0, std::as_bytes(scene.attributes));
    gpu.has_vertex_colors = std::any_of(scene.attributes.begin(), scene.attributes.end(),
                                        [](const scene::VertexAttributes& a) { return a.color != 0xFFFFFFFFu; });
    FF_ASSIGN(gpu.indices, gl::Buffer::make(scene.indices.size_bytes()));
    write_indices(scene, gpu.layout, gpu.indices, progress);
    const bool has_blended = std::any_of(scene.materials.begin(), scene.materials.end(), [](const auto& material) {
        return layer_of(material) == MaterialLayer::blended;
    });
    const auto names =
        std::as_bytes(std::span(gpu.layout.reordered)).first(has_blended ? 4 * gpu.layout.reordered.size() : 0);
    FF_ASSIGN(gpu.triangle_names, gl::Buffer::make(names.size()));
    gpu.triangle_names.write(0, names);
    gpu.textures.reserve(scene.textures.size());
    for (const scene::Texture& texture : scene.textures) {
        FF_ASSIGN(gl::Texture uploaded, upload_texture(scene, texture));
        gpu.textures.push_back(std::move(uploaded));
        progress.advance();
    }
    return gpu;
}

}  // namespace ff::nearfield
