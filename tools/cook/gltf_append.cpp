#include "tools/cook/gltf_append.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace ff::cook {
namespace {

struct MaterialUse {
    bool used = false;
    bool translucent_vertices = false;  // some vertex colour has alpha below 1
};

std::vector<MaterialUse> material_use(const std::vector<scene::MeshSource>& meshes, std::size_t material_count) {
    std::vector<MaterialUse> use(material_count);
    for (const scene::MeshSource& mesh : meshes)
        for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
            MaterialUse& material = use[mesh.triangle_materials[t]];
            material.used = true;
            for (std::size_t corner = 0; corner < 3; ++corner)
                if (mesh.attributes[mesh.indices[3 * t + corner]].color >> 24 != 255)
                    material.translucent_vertices = true;
        }
    return use;
}

// Rays and rasteriser pay for alpha; a material whose alpha never matters is opaque.
void drop_needless_alpha(ImportedMaterials& imported, const std::vector<MaterialUse>& use) {
    std::vector<std::uint32_t> least_alpha;
    for (const SourceTexture& texture : imported.textures) {
        std::uint32_t least = 255;
        for (const std::uint32_t texel : texture.rgba) least = std::min(least, texel >> 24);
        least_alpha.push_back(least);
    }
    for (std::size_t i = 0; i < imported.materials.size(); ++i) {
        scene::Material& material = imported.materials[i];
        if (use[i].translucent_vertices) continue;
        const bool textured = material.base_color_texture != scene::kNoTexture;
        const float alpha =
            material.base_color.w * (textured ? static_cast<float>(least_alpha[material.base_color_texture]) : 255.0f);
        if (alpha >= 255.0f * material.alpha_cutoff) material.flags &= ~scene::kMaterialAlphaMask;
        if (alpha >= 255.0f) material.flags &= ~scene::kMaterialBlend;
    }
}

std::uint32_t moved_texture(std::uint32_t texture, std::uint32_t first) {
    return texture == scene::kNoTexture ? texture : texture + first;
}

}  // namespace

Result<std::vector<std::uint16_t>> append_materials(const GltfFile& file, ImportedMaterials imported,
                                                    const std::vector<scene::MeshSource>& meshes, WorldSource& into) {
    const std::vector<MaterialUse> use = material_use(meshes, imported.materials.size());
    drop_needless_alpha(imported, use);

    // Unused materials stay out: models share one world's 16-bit ids.
    const auto first_texture = static_cast<std::uint32_t>(into.textures.size());
    std::vector<std::uint16_t> material_ids(imported.materials.size(), 0);
    const auto used = static_cast<std::size_t>(std::count_if(use.begin(), use.end(), [](auto& m) { return m.used; }));
    if (into.materials.size() + used > 0xFFFF)
        return file.error("materials", fmt::format("{} more in a world of {}; expected at most 65535 together", used,
                                                   into.materials.size()));
    for (std::size_t i = 0; i < imported.materials.size(); ++i) {
        if (!use[i].used) continue;
        scene::Material material = imported.materials[i];
        material.base_color_texture = moved_texture(material.base_color_texture, first_texture);
        material.emissive_texture = moved_texture(material.emissive_texture, first_texture);
        material.metallic_roughness_texture = moved_texture(material.metallic_roughness_texture, first_texture);
        material_ids[i] = static_cast<std::uint16_t>(into.materials.size());
        into.materials.push_back(material);
    }
    std::move(imported.textures.begin(), imported.textures.end(), std::back_inserter(into.textures));
    return material_ids;
}

std::uint32_t append_mesh(std::string name, scene::MeshSource mesh, const std::vector<std::uint16_t>& material_ids,
                          WorldSource& into) {
    for (std::uint16_t& material : mesh.triangle_materials) material = material_ids[material];
    into.meshes.push_back({.name = std::move(name), .geometry = std::move(mesh)});
    return static_cast<std::uint32_t>(into.meshes.size() - 1);
}

}  // namespace ff::cook
