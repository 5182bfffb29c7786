#include <algorithm>

#include "engine/effects/registry.h"

namespace ff::effects {
namespace {

/// From farther away water mirrors the sky alone.
constexpr double kWaterMirrorsWithinM = 1500.0;

}  // namespace

std::vector<DBox3> find_material(const scene::StaticScene& scene, std::uint32_t flags) {
    std::vector<DBox3> boxes;
    for (const scene::Instance& instance : scene.instances)
        if ((scene.meshes[instance.mesh].material_flags & flags) != 0) boxes.push_back(instance.bounds);
    return boxes;
}

bool is_any_within(std::span<const DBox3> boxes, const WorldPos& eye, double within_m) {
    return std::any_of(boxes.begin(), boxes.end(), [&](const DBox3& box) { return distance_to(box, eye) < within_m; });
}

Decision decide_reflections(const Conditions& conditions) {
    const SceneFacts& facts = conditions.facts;
    if (facts.water.empty() && facts.mirrors.empty()) return {State::off, "nothing mirrors"};
    if (conditions.by_opengl) return {State::off, "the rasteriser mirrors the sky alone"};
    if (conditions.reflection_rays == 0) return {State::off, "it has no rays"};
    if (is_any_within(facts.water, conditions.eye, kWaterMirrorsWithinM)) return {State::active, "open water is near"};
    if (is_any_within(facts.mirrors, conditions.eye, double(conditions.reflections_within_m)))
        return {State::active, "glass or metal is near"};
    return {State::idle, "no mirror is near"};
}

}  // namespace ff::effects
