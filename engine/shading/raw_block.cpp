#include "engine/shading/raw_block.h"

#include <bit>
#include <cstring>

#include "engine/shading/texture_info.h"

namespace ff::shading {
namespace {

void store_int(float* record, int row, std::int32_t value) {
    record[row * kBlock] = std::bit_cast<float>(value);
}

/// Writes a texture's address; returns its info, or 0 where the material has none.
std::int32_t store_texture(const scene::StaticScene& scene, std::uint32_t id, float* record, int texture_row) {
    if (id == scene::kNoTexture) {
        store_int(record, texture_row, 0);  // lanes without a texture still load texel 0 beside lanes with one
        return 0;
    }
    const scene::Texture& texture = scene.textures[id];
    store_int(record, texture_row, std::int32_t(texel_indices_fit(scene) ? texture.first_texel : id));
    return texture_info(texture) | kLaneTextured;
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
    for (int i = 0; i < count; ++i, ++record) {
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
        if (needs.full && material.emissive != Vec3(0.0f)) {
            bits |= kLaneEmissive;
            const std::int32_t info = store_texture(scene, material.emissive_texture, record, kRowEmissiveTexture);
            store_int(record, kRowEmissiveInfo, info);
            raw.any_bits |= info & kAnyWrapBit;
        }
        if (needs.full) {
            for (int k = 0; k < 3; ++k) record[(kRowEmissive + k) * kBlock] = material.emissive[k];
            if (raw.vertex_color[0][i] != raw.vertex_color[1][i] || raw.vertex_color[0][i] != raw.vertex_color[2][i])
                bits |= kLaneVertexColor;
            if (!unlit && (material.flags & scene::kMaterialSpecular)) {
                bits |= kLaneSpecular | kLanePixelLit;
                record[kRowMetallic * kBlock] = material.metallic;
                record[kRowRoughness * kBlock] = material.roughness;
                const std::int32_t info =
                    store_texture(scene, material.metallic_roughness_texture, record, kRowRoughnessTexture);
                store_int(record, kRowRoughnessInfo, info);
                raw.any_bits |= info & kAnyWrapBit;
            } else if (!unlit && (normal_bits[0] != normal_bits[1] || normal_bits[0] != normal_bits[2])) {
                bits |= kLanePixelLit;
            }
            bits |= store_texture(scene, material.base_color_texture, record, kRowTexture);
            for (int k = 0; k < 3; ++k) raw.color[k][i] = material.base_color[k];
        }
        raw.info[i] = bits;
        raw.any_bits |= bits;
    }
}

}  // namespace ff::shading
