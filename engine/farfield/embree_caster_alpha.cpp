#include "engine/farfield/embree_caster_alpha.h"

#include <cmath>

namespace ff::farfield::embree {
namespace {
bool is_opaque_at(const scene::StaticScene& scene, const scene::Mesh& mesh, std::uint32_t triangle, float u, float v) {
    const std::size_t t = std::size_t(mesh.first_triangle) + triangle;
    const scene::Material& material = scene.materials[scene.triangle_materials[t]];
    if ((material.flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) == 0) return true;
    if (material.base_color_texture == scene::kNoTexture) return material.base_color.a >= material.alpha_cutoff;
    const std::uint32_t* corners = &scene.indices[3 * t];
    const Vec2 a = scene.attributes[mesh.first_vertex + corners[0]].uv;
    const Vec2 b = scene.attributes[mesh.first_vertex + corners[1]].uv;
    const Vec2 c = scene.attributes[mesh.first_vertex + corners[2]].uv;
    const Vec2 uv = a * (1.0f - u - v) + b * u + c * v;
    const scene::Texture& texture = scene.textures[material.base_color_texture];
    const auto x = std::uint32_t(std::int64_t(std::floor(uv.x * float(texture.width)))) & (texture.width - 1);
    const auto y = std::uint32_t(std::int64_t(std::floor(uv.y * float(texture.height)))) & (texture.height - 1);
    const std::uint32_t texel = scene.texels[texture.first_texel + std::size_t(y) * texture.width + x];
    return float(texel >> 24) * (material.base_color.a / 255.0f) >= material.alpha_cutoff;
}
}  // namespace

void filter_see_through(const RTCFilterFunctionNArguments* arguments) {
    const auto& mesh_of = *static_cast<const AlphaMesh*>(arguments->geometryUserPtr);
    const scene::StaticScene& scene = mesh_of.owner->scene;
    const scene::Mesh& mesh = scene.meshes[mesh_of.mesh];
    const unsigned count = arguments->N;
    for (unsigned lane = 0; lane < count; ++lane) {
        if (arguments->valid[lane] == 0) continue;
        if (!is_opaque_at(scene, mesh, RTCHitN_primID(arguments->hit, count, lane),
                          RTCHitN_u(arguments->hit, count, lane), RTCHitN_v(arguments->hit, count, lane)))
            arguments->valid[lane] = 0;
    }
}

}  // namespace ff::farfield::embree
