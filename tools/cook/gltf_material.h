#pragma once
// glTF materials, textures and images to the engine's.

#include <vector>

#include "engine/core/result.h"
#include "engine/math/types.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/gltf_accessor.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// KHR_texture_transform of a material's textures: uv' = offset + rotation * scale * uv.
struct UvTransform {
    int set = 0;  ///< TEXCOORD_set
    float m[2][3] = {{1, 0, 0}, {0, 1, 0}};
    [[nodiscard]] Vec2 apply(float u, float v) const {
        return {m[0][0] * u + m[0][1] * v + m[0][2], m[1][0] * u + m[1][1] * v + m[1][2]};
    }
    friend bool operator==(const UvTransform&, const UvTransform&) = default;
};

/// A model's materials with its textures; ids are the model's own, one more material than the file has: the default.
struct ImportedMaterials {
    std::vector<SourceTexture> textures;
    std::vector<scene::Material> materials;  ///< [glTF materials + 1]
    std::vector<UvTransform> uv_transforms;  ///< same
    std::vector<bool> has_texture;           ///< same: uvs matter
};

/// Reads materials, and decodes in parallel the images that they use.
/// Errors: an image that is none; more than 65535 materials.
[[nodiscard]] Result<ImportedMaterials> read_materials(GltfFile& file, const GltfData& data, CookContext& context);

}  // namespace ff::cook
