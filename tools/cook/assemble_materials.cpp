#include "tools/cook/assemble_materials.h"

#include <cstring>
#include <map>
#include <string>
#include <tuple>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/scene/texture_mips.h"

namespace ff::cook {
namespace {

using scene::kNoTexture;

void add_textures(const WorldSource& source, const std::vector<std::uint32_t>& order, scene::SceneData& scene) {
    std::vector<scene::Texture> described(order.size());
    std::vector<std::vector<std::uint32_t>> chains(order.size());
    Progress progress("mip-mapping textures", order.size());
    parallel_for(order.size(), [&](std::size_t i) {
        const SourceTexture& texture = source.textures[order[i]];
        described[i] = scene::append_mip_chain(texture.rgba, texture.width, texture.height, chains[i]);
        described[i].wrap_u = texture.wrap_u;
        described[i].wrap_v = texture.wrap_v;
        progress.advance();
    });
    std::size_t total = scene.texels.size();
    for (const auto& chain : chains) total += chain.size();
    scene.texels.reserve(total);
    for (std::size_t i = 0; i < order.size(); ++i) {
        described[i].first_texel = scene.texels.size();
        scene.texels.insert(scene.texels.end(), chains[i].begin(), chains[i].end());
        scene.textures.push_back(described[i]);
        chains[i] = {};
    }
}

std::string bytes_of(const scene::Material& material) {
    static_assert(sizeof(scene::Material) == 56);  // no padding: equal bytes are equal materials
    std::string bytes(sizeof material, '\0');
    std::memcpy(bytes.data(), &material, sizeof material);
    return bytes;
}

}  // namespace

std::vector<std::uint16_t> add_materials(const WorldSource& source, const std::vector<bool>& used,
                                         scene::SceneData& scene) {
    std::map<std::tuple<std::string, scene::Wrap, scene::Wrap>, std::uint32_t> known_textures;
    std::vector<std::uint32_t> texture_order;
    const auto texture_id = [&](std::uint32_t texture) {
        if (texture == kNoTexture) return texture;
        const SourceTexture& t = source.textures[texture];
        const auto next = static_cast<std::uint32_t>(scene.textures.size() + texture_order.size());
        const auto [entry, is_new] = known_textures.try_emplace({t.content_hash, t.wrap_u, t.wrap_v}, next);
        if (is_new) texture_order.push_back(texture);
        return entry->second;
    };
    std::map<std::string, std::uint16_t> known_materials;
    std::vector<std::uint16_t> ids(source.materials.size(), 0);
    for (std::size_t i = 0; i < source.materials.size(); ++i) {
        if (!used[i]) continue;
        scene::Material material = source.materials[i];
        material.base_color_texture = texture_id(material.base_color_texture);
        material.emissive_texture = texture_id(material.emissive_texture);
        material.metallic_roughness_texture = texture_id(material.metallic_roughness_texture);
        const auto next = static_cast<std::uint16_t>(scene.materials.size());
        const auto [entry, is_new] = known_materials.try_emplace(bytes_of(material), next);
        if (is_new) scene.materials.push_back(material);
        ids[i] = entry->second;
    }
    add_textures(source, texture_order, scene);
    return ids;
}

}  // namespace ff::cook
