#include <algorithm>

#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_transparency(const Conditions& conditions) {
    const SceneFacts& facts = conditions.facts;
    if (facts.layer_index == nullptr || facts.layer_index->is_empty()) return {State::off, "nothing is see-through"};
    const float within_m = conditions.blend_within_m;
    if (!(within_m > 0.0f)) return {State::off, "shown by coverage"};
    if (conditions.by_opengl) return {State::active, "drawn by OpenGL"};
    const auto is_blended = [&](const scene::Instance& instance) {
        return (conditions.scene.meshes[instance.mesh].material_flags & scene::kMaterialBlend) != 0;
    };
    if (std::any_of(conditions.dynamic.begin(), conditions.dynamic.end(), is_blended))
        return {State::active, "something see-through moves"};
    if (farfield::has_layers_within(conditions.scene, *facts.layer_index, conditions.eye, within_m))
        return {State::active, "something see-through is near"};
    return {State::idle, "nothing see-through is near"};
}

}  // namespace ff::effects
