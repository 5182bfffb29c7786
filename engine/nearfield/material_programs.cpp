#include "engine/nearfield/material_programs.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>

#include "engine/nearfield/mesh_layout.h"

namespace ff::nearfield {
namespace {

/// As shaders/material.glsl reads it.
struct MaterialUniforms {
    Vec4 base_color;
    Vec4 emissive_cutoff;     ///< w: alpha cutoff, -1 for blended materials
    Vec4 metallic_roughness;  ///< x, y; base colour texture: z texels of level 0, w wraps, -1 for none
    Vec4 foliage;             ///< x: 1 where wind moves the picture
};
static_assert(sizeof(MaterialUniforms) == kMaterialUniformBytes);

struct FeatureName {
    std::uint32_t bit;
    const char* define;
};
constexpr FeatureName kFeatureNames[] = {
    {kFeatureBaseTexture, "#define BASE_TEXTURE\n"},
    {kFeatureAlphaMask, "#define ALPHA_MASK\n"},
    {kFeatureBlend, "#define BLEND\n"},
    {kFeatureUnlit, "#define UNLIT\n"},
    {kFeatureSpecular, "#define SPECULAR\n"},
    {kFeatureRoughnessTexture, "#define ROUGHNESS_TEXTURE\n"},
    {kFeatureEmissiveTexture, "#define EMISSIVE_TEXTURE\n"},
    {kFeatureVertexColor, "#define VERTEX_COLOR\n"},
    {kFeatureFog, "#define FOG\n"},
    {kFeatureAir, "#define AIR\n"},
    {kFeatureSways, "#define SWAYS\n"},
};

}  // namespace

std::uint32_t features_of(const scene::Material& material, const scene::Environment& environment,
                          bool has_vertex_colors) {
    std::uint32_t features = has_vertex_colors ? kFeatureVertexColor : 0u;
    const auto add = [&](bool wanted, MaterialFeatures feature) {
        if (wanted) features |= feature;
    };
    add(environment.fog_density_per_m > 0.0f, kFeatureFog);
    add(environment.atmosphere.turbidity > 0.0f, kFeatureAir);
    const bool unlit = (material.flags & scene::kMaterialUnlit) != 0;
    const bool specular = !unlit && (material.flags & scene::kMaterialSpecular) != 0;
    add(material.base_color_texture != scene::kNoTexture, kFeatureBaseTexture);
    add(layer_of(material) == MaterialLayer::masked, kFeatureAlphaMask);
    add(layer_of(material) == MaterialLayer::blended, kFeatureBlend);
    const bool blows = environment.weather.wind_m_s != Vec2(0.0f);
    add(blows && (material.flags & scene::kMaterialSways) != 0, kFeatureSways);
    add(unlit, kFeatureUnlit);
    add(specular, kFeatureSpecular);
    add(specular && material.metallic_roughness_texture != scene::kNoTexture, kFeatureRoughnessTexture);
    add(material.emissive_texture != scene::kNoTexture, kFeatureEmissiveTexture);
    return features;
}

Result<MaterialPrograms> make_shaded_programs(const scene::StaticScene& scene, bool has_vertex_colors) {
    MaterialPrograms out;
    std::vector<std::uint32_t> features_of_program;
    for (const scene::Material& material : scene.materials) {
        const std::uint32_t features = features_of(material, scene.environment, has_vertex_colors);
        const auto known = std::find(features_of_program.begin(), features_of_program.end(), features);
        out.program_of.push_back(std::uint32_t(known - features_of_program.begin()));
        if (known != features_of_program.end()) continue;
        std::string defines;
        for (const FeatureName& name : kFeatureNames)
            if (features & name.bit) defines += name.define;
        FF_ASSIGN(gl::Program program, gl::Program::make("near_shaded.vert.glsl", "near_shaded.frag.glsl", defines));
        out.programs.push_back(std::move(program));
        out.defines.push_back(std::move(defines));
        features_of_program.push_back(features);
    }

    out.draw_order.resize(scene.materials.size());
    std::iota(out.draw_order.begin(), out.draw_order.end(), 0u);
    std::stable_sort(out.draw_order.begin(), out.draw_order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const MaterialLayer la = layer_of(scene.materials[a]), lb = layer_of(scene.materials[b]);
        return la != lb ? la < lb : out.program_of[a] < out.program_of[b];
    });

    GLint alignment = 256;
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
    const auto unit = std::uint32_t(alignment);
    out.stride_bytes = (std::uint32_t(sizeof(MaterialUniforms)) + unit - 1) / unit * unit;
    std::vector<std::byte> bytes(std::size_t(out.stride_bytes) * scene.materials.size());
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const scene::Material& material = scene.materials[m];
        float texels = 1.0f, wraps = -1.0f;
        if (material.base_color_texture != scene::kNoTexture) {
            const scene::Texture& texture = scene.textures[material.base_color_texture];
            texels = float(texture.width) * float(texture.height);
            wraps = float(texture.wrap_u) + 3.0f * float(texture.wrap_v);
        }
        const MaterialUniforms uniforms{
            .base_color = material.base_color,
            .emissive_cutoff =
                Vec4(material.emissive, layer_of(material) == MaterialLayer::blended ? -1.0f : material.alpha_cutoff),
            .metallic_roughness = Vec4(material.metallic, material.roughness, texels, wraps),
            .foliage = Vec4((material.flags & scene::kMaterialSways) != 0 ? 1.0f : 0.0f, 0.0f, 0.0f, 0.0f),
        };
        std::memcpy(bytes.data() + m * out.stride_bytes, &uniforms, sizeof uniforms);
    }
    FF_ASSIGN(out.uniforms, gl::Buffer::make(bytes.size()));
    out.uniforms.write(0, bytes);
    return out;
}

}  // namespace ff::nearfield
