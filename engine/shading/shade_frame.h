#pragma once
// One call of shade_tiles as the kernels see it.

#include <span>

#include "engine/shading/shading_model.h"
#include "engine/shading/shading_pass.h"

namespace ff::shading {

struct ShadeFrame {
    const scene::StaticScene& scene;
    std::span<const scene::Instance> dynamic;
    const PinholeView& view;
    const farfield::VisibilityBuffer& visibility;
    ShadeSettings settings;
    ShadingUniforms uniforms;
    NearAir near_air;
    Image& out;

    /// nullptr: no such instance.
    [[nodiscard]] const scene::Instance* instance(std::uint32_t id) const {
        const std::size_t fixed = scene.instances.size();
        if (id < fixed) return &scene.instances[id];
        return id - fixed < dynamic.size() ? &dynamic[id - fixed] : nullptr;
    }
};

}  // namespace ff::shading
