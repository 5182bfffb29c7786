#include "engine/shading/raw_block.h"

#include <bit>
#include <cstring>

#include "engine/shading/texture_info.h"

namespace ff::shading {
namespace {

/// A texture's address and shape as records hold them; zeros where the material has none.
struct TextureRows {
    std::int32_t first_texel = 0;  ///< lanes without a texture still load texel 0 beside lanes with one
    std::int32_t info = 0;
    std::int32_t wraps = 0;  ///< kLaneWraps or nothing
};

TextureRows texture_rows(const scene::StaticScene& scene, std::uint32_t id) {
    if (id == scene::kNoTexture) return {};
    const scene::Texture& texture = scene.textures[id];
    const std::int32_t info = texture_info(texture);
    return {std::int32_t(texel_indices_fit(scene) ? texture.first_texel : id), info | kLaneTextured,
            info & kAnyWrapBit ? kLaneWraps : 0};
}

/// Emissive factor times the mean of its texture.
Vec3 mean_emissive(const scene::StaticScene& scene, const scene::Material& material) {
    if (material.emissive_texture == scene::kNoTexture) return material.emissive;
    return material.emissive * mean_texture_color(scene, scene.textures[material.emissive_texture]);
}

}  // namespace

void prefetch_vertices(const ShadeFrame& frame, const TriangleName* names, int count) {
    for (int i = 0; i < count; ++i) {
        const scene::Mesh& mesh = frame.scene.meshes[frame.instance(names[i].instance)->mesh];
        const std::uint32_t* corner = &frame.scene.indices[3 * (std::size_t(mesh.first_triangle) + names[i].triangle)];
        for (int k = 0; k < 3; ++k) {
            __builtin_prefetch(&frame.scene.positions[mesh.first_vertex + corner[k]]);
            __builtin_prefetch(&frame.scene.attributes[mesh.first_vertex + corner[k]]);
        }
    }
}

void load_raw_block(const ShadeFrame& frame, const TriangleName* names, int count, TileNeeds needs, RawBlock& raw,
                    float* record) {
    const scene::StaticScene& scene = frame.scene;
    raw.any_bits = 0;
    std::uint32_t last_instance = farfield::kSkyInstance;
    const scene::Instance* instance = nullptr;
    const scene::Mesh* mesh = nullptr;
    Vec3 offset(0.0f);
    for (int i = 0; i < count; ++i, record += kRecordFloats) {
        if (names[i].instance != last_instance) {
            last_instance = names[i].instance;
            instance = frame.instance(last_instance);
            mesh = &scene.meshes[instance->mesh];
            offset = Vec3(instance->position - frame.view.position);
        }
        const std::size_t triangle = std::size_t(mesh->first_triangle) + names[i].triangle;
        const std::uint32_t* corners = &scene.indices[3 * triangle];
        const scene::Material& material = scene.materials[scene.triangle_materials[triangle]];
        for (int k = 0; k < 3; ++k) {
            raw.offset[k][i] = offset[k];
            for (int row = 0; row < 3; ++row) raw.world_from_mesh[3 * k + row][i] = instance->world_from_mesh[k][row];
        }
        std::uint32_t normal_bits[3];
        for (int k = 0; k < 3; ++k) {
            const std::size_t vertex = mesh->first_vertex + corners[k];
            const Vec3& position = scene.positions[vertex];
            const scene::VertexAttributes& attributes = scene.attributes[vertex];
            raw.position[3 * k][i] = position.x;
            raw.position[3 * k + 1][i] = position.y;
            raw.position[3 * k + 2][i] = position.z;
            raw.uv[2 * k][i] = attributes.uv.x;
            raw.uv[2 * k + 1][i] = attributes.uv.y;
            std::memcpy(&normal_bits[k], attributes.normal_oct, 4);
            raw.normal[k][i] = std::int32_t(normal_bits[k]);
            raw.vertex_color[k][i] = attributes.color;
            if (!needs.full) break;  // the prelit colour asks for one corner only
        }
        const bool unlit = material.flags & scene::kMaterialUnlit;
        std::int32_t bits = unlit ? kLaneUnlit : 0;
        if (needs.prelit) {
            raw.prelit[i] = scene.prelit_colors[triangle];
            const Vec3 emissive = mean_emissive(scene, material);
            for (int k = 0; k < 3; ++k) raw.prelit_emissive[k][i] = emissive[k];
        }
        if (needs.full) {
            TextureRows emissive;
            if (material.emissive != Vec3(0.0f)) {
                emissive = texture_rows(scene, material.emissive_texture);
                bits |= kLaneEmissive | emissive.wraps;
            }
            raw.emissive_info[i] = emissive.info;
            for (int k = 0; k < 3; ++k) record[kQuadEmissive + k] = material.emissive[k];
            record[kQuadEmissive + 3] = std::bit_cast<float>(emissive.first_texel);
            if (raw.vertex_color[0][i] != raw.vertex_color[1][i] || raw.vertex_color[0][i] != raw.vertex_color[2][i])
                bits |= kLaneVertexColor;
            if (!unlit && (material.flags & scene::kMaterialSpecular)) {
                const TextureRows map = texture_rows(scene, material.metallic_roughness_texture);
                bits |= kLaneSpecular | kLanePixelLit | map.wraps;
                const bool is_water = (material.flags & scene::kMaterialWater) != 0;
                if (frame.settings.waves != nullptr && is_water) bits |= kLaneWater;
                if (frame.settings.reflections != nullptr && is_mirror(material))
                    bits |= is_water ? kLaneMirror : kLaneMirror | kLaneFades;
                record[kQuadSpecular] = bits & kLaneWater ? material.wave_strength() : material.metallic;
                record[kQuadSpecular + 1] = material.roughness;
                record[kQuadSpecular + 2] = std::bit_cast<float>(map.info);
                record[kQuadSpecular + 3] = std::bit_cast<float>(map.first_texel);
            } else if (!unlit &&
                       (needs.light_by_pixel || normal_bits[0] != normal_bits[1] || normal_bits[0] != normal_bits[2])) {
                bits |= kLanePixelLit;
            }
            const TextureRows base = texture_rows(scene, material.base_color_texture);
            bits |= base.info | base.wraps;
            if ((material.flags & scene::kMaterialSways) != 0 && !frame.view.sway.is_none()) bits |= kLaneSways;
            raw.texture[i] = base.first_texel;
            for (int k = 0; k < 3; ++k) raw.color[k][i] = material.base_color[k];
        }
        raw.info[i] = bits;
        raw.any_bits |= bits;
    }
}

}  // namespace ff::shading
