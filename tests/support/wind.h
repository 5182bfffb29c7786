#pragma once
// Wind for tests: foliage in any world, and a movement as a frame would plan it.

#include "engine/math/leaf_sway.h"
#include "engine/scene/scene_data.h"

namespace ff::test {

/// Makes everything masked foliage.
inline void let_leaves_sway(scene::SceneData& data) {
    const auto mark = [](std::uint32_t& flags) {
        if ((flags & scene::kMaterialAlphaMask) != 0) flags |= scene::kMaterialSways;
    };
    for (scene::Material& material : data.materials) mark(material.flags);
    for (scene::Mesh& mesh : data.meshes) mark(mesh.material_flags);
}

/// A storm: as far as leaves move. Other times move them elsewhere.
inline LeafSway storm(float time_s, float within_m = 60.0f) {
    return {.gust = {{0.03f, 0.0f, 0.01f}, 0.3f - 0.4f * time_s},
            .along_u = {{0.31f, 0.13f, 0.2f}, 0.1f - 0.83f * time_s},
            .along_v = {{0.2f, -0.17f, -0.4f}, -0.2f - 1.17f * time_s},
            .amplitude_m = 0.1f,
            .within_m = within_m};
}

}  // namespace ff::test
