#pragma once
// Which program draws which material. A program does only what its materials call for: on a software rasteriser every
// sampler and every branch of a fragment shader is paid for, taken or not.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/gl/buffer.h"
#include "engine/gl/program.h"
#include "engine/scene/static_scene.h"

namespace ff::nearfield {

/// What a material calls for, as bits; a program for each combination that occurs.
enum MaterialFeatures : std::uint32_t {
    kFeatureBaseTexture = 1u << 0,
    kFeatureAlphaMask = 1u << 1,
    kFeatureBlend = 1u << 2,
    kFeatureUnlit = 1u << 3,
    kFeatureSpecular = 1u << 4,
    kFeatureRoughnessTexture = 1u << 5,
    kFeatureEmissiveTexture = 1u << 6,
    kFeatureVertexColor = 1u << 7,
    kFeatureFog = 1u << 8,
    kFeatureAir = 1u << 9,
    kFeatureSways = 1u << 10,
};

/// Size of a material's block in shaders/material.glsl.
inline constexpr std::size_t kMaterialUniformBytes = 64;

[[nodiscard]] std::uint32_t features_of(const scene::Material& material, const scene::Environment& environment,
                                        bool has_vertex_colors);

struct MaterialPrograms {
    std::vector<gl::Program> programs;
    std::vector<std::string> defines;       ///< by program, a line each
    std::vector<std::uint32_t> program_of;  ///< by material
    std::vector<std::uint32_t> draw_order;  ///< materials: opaque before masked before blended, then by program
    gl::Buffer uniforms;                    ///< a std140 block per material, stride_bytes apart
    std::uint32_t stride_bytes = 256;
};

/// Compiles the programs of a scene's materials and fills their uniforms.
Result<MaterialPrograms> make_shaded_programs(const scene::StaticScene& scene, bool has_vertex_colors);

}  // namespace ff::nearfield
