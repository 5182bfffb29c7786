#include "engine/scene/prelit_colors.h"

#include <algorithm>
#include <cmath>

#include "engine/core/jobs.h"
#include "engine/scene/texel_address.h"
#include "engine/scene/texture_mips.h"

namespace ff::scene {
namespace {

Vec4 unpack_linear(std::uint32_t c) {
    return Vec4(float(c & 0xFF), float((c >> 8) & 0xFF), float((c >> 16) & 0xFF), float(c >> 24)) / 255.0f;
}

std::uint32_t pack_linear(const Vec4& c) {
    std::uint32_t out = 0;
    for (int i = 0; i < 4; ++i) out |= std::uint32_t(std::clamp(c[i], 0.0f, 1.0f) * 255.0f + 0.5f) << (8 * i);
    return out;
}

Vec4 mean_texture_color(const SceneData& scene, const Texture& texture, const Vec2 (&uv)[3]) {
    const Vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    const float texel_area = 0.5f * std::abs(a.x * b.y - a.y * b.x) * float(texture.width) * float(texture.height);
    const float lod = texel_area > 1.0f ? 0.5f * std::log2(texel_area) : 0.0f;
    const auto level = std::uint32_t(std::min(lod + 0.5f, float(texture.level_count - 1)));
    const Vec2 middle = (uv[0] + uv[1] + uv[2]) / 3.0f;
    const std::uint32_t texel = scene.texels[texel_index(texture, middle, level)];
    const auto linear = linear_of_srgb();
    return Vec4(linear[texel & 0xFF], linear[(texel >> 8) & 0xFF], linear[(texel >> 16) & 0xFF],
                float(texel >> 24) / 255.0f);
}

}  // namespace

std::vector<std::uint32_t> make_prelit_colors(const SceneData& scene) {
    std::vector<std::uint32_t> colors(scene.triangle_materials.size());
    for (const Mesh& mesh : scene.meshes) {
        parallel_ranges(mesh.triangle_count, 16384, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t triangle = mesh.first_triangle + i;
                const Material& material = scene.materials[scene.triangle_materials[triangle]];
                Vec2 uv[3];
                Vec4 color(0.0f);
                for (std::size_t corner = 0; corner < 3; ++corner) {
                    const VertexAttributes& vertex =
                        scene.attributes[mesh.first_vertex + scene.indices[3 * triangle + corner]];
                    uv[corner] = vertex.uv;
                    color += unpack_linear(vertex.color) / 3.0f;
                }
                color *= material.base_color;
                if (material.base_color_texture != kNoTexture)
                    color *= mean_texture_color(scene, scene.textures[material.base_color_texture], uv);
                colors[triangle] = pack_linear(color);
            }
        });
    }
    return colors;
}

}  // namespace ff::scene
