#include "engine/farfield/alpha_test.h"

#include <glm/geometric.hpp>

namespace ff::farfield {

AlphaSurface make_alpha_surface(const scene::StaticScene& scene, const scene::Instance& instance,
                                std::uint32_t instance_id, std::uint32_t triangle, const Vec3 (&corners)[3]) {
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const std::size_t t = std::size_t(mesh.first_triangle) + triangle;
    const scene::Material& material = scene.materials[scene.triangle_materials[t]];
    AlphaSurface surface;
    if ((material.flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) == 0) return surface;
    surface.is_see_through = true;
    surface.is_blended = (material.flags & scene::kMaterialBlend) != 0;
    surface.cutoff = material.alpha_cutoff;
    surface.seed = instance_id * 0xC2B2AE3Du + triangle * 0x27D4EB2Fu;
    for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::size_t vertex = mesh.first_vertex + scene.indices[3 * t + corner];
        surface.uv[corner] = scene.attributes[vertex].uv;
        surface.alpha[corner] = material.base_color.a * (float(scene.attributes[vertex].color >> 24) / 255.0f);
    }
    if (material.base_color_texture == scene::kNoTexture) return surface;
    surface.texture = &scene.textures[material.base_color_texture];
    surface.last_level = last_alpha_level(*surface.texture);
    surface.texels = scene.texels.data() + surface.texture->first_texel;
    const Vec2 a = surface.uv[1] - surface.uv[0], b = surface.uv[2] - surface.uv[0];
    const float uv_area = std::abs(a.x * b.y - a.y * b.x);
    const float texel_area = uv_area * float(surface.texture->width) * float(surface.texture->height);
    const Mat3& m = instance.world_from_mesh;
    const Vec3 p0 = m * corners[0], p1 = m * corners[1], p2 = m * corners[2];
    const float world_area = glm::length(glm::cross(p1 - p0, p2 - p0));
    const float ratio = std::sqrt(texel_area / world_area);
    surface.texels_per_m = std::isfinite(ratio) ? ratio : 0.0f;
    if ((material.flags & scene::kMaterialSways) != 0) {
        const float uv_per_m = std::sqrt(uv_area / world_area);
        surface.sway_uv_per_m = std::isfinite(uv_per_m) ? uv_per_m : 0.0f;
    }
    return surface;
}

AlphaSurface make_alpha_surface(const scene::StaticScene& scene, const scene::Instance& instance,
                                std::uint32_t instance_id, std::uint32_t triangle) {
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const std::size_t first = 3 * (std::size_t(mesh.first_triangle) + triangle);
    Vec3 corners[3];
    for (std::size_t corner = 0; corner < 3; ++corner)
        corners[corner] = scene.positions[mesh.first_vertex + scene.indices[first + corner]];
    return make_alpha_surface(scene, instance, instance_id, triangle, corners);
}

}  // namespace ff::farfield
