#include "engine/effects/registry.h"

namespace ff::effects {
namespace {

/// Farther away all waves are smaller than pixels, and the mirror is as rough as it gets.
constexpr double kWavesWithinM = 1500.0;

}  // namespace

std::vector<DBox3> find_water(const scene::StaticScene& scene) {
    std::vector<DBox3> boxes;
    for (const scene::Instance& instance : scene.instances)
        if ((scene.meshes[instance.mesh].material_flags & scene::kMaterialWater) != 0) boxes.push_back(instance.bounds);
    return boxes;
}

Decision decide_water(const Conditions& conditions) {
    if (conditions.facts.water.empty()) return {State::off, "the scene has no open water"};
    if (conditions.by_opengl) return {State::off, "the rasteriser knows no waves"};
    for (const DBox3& box : conditions.facts.water)
        if (distance_to(box, conditions.eye) < kWavesWithinM) return {State::active, "open water is near"};
    return {State::idle, "no open water is near"};
}

}  // namespace ff::effects
