#include "engine/effects/wind.h"

#include <algorithm>
#include <cmath>

#include "engine/effects/registry.h"

namespace ff::effects {
namespace {

bool is_foliage(const scene::StaticScene& scene, const scene::Instance& instance) {
    return (scene.meshes[instance.mesh].material_flags & scene::kMaterialSways) != 0;
}

/// A train with its phase at the eye, where it is taken modulo a turn in double precision.
LeafSway::Train make_train(const DVec3& turns_per_m, double turns_per_s, const WorldPos& eye, double time_s) {
    const double turns = glm::dot(turns_per_m, DVec3(eye)) - turns_per_s * time_s;
    return {Vec3(turns_per_m), float(turns - std::floor(turns + 0.5))};
}

}  // namespace

bool has_foliage(const scene::StaticScene& scene) {
    return std::any_of(scene.meshes.begin(), scene.meshes.end(),
                       [](const scene::Mesh& mesh) { return (mesh.material_flags & scene::kMaterialSways) != 0; });
}

bool is_foliage_within(const scene::StaticScene& scene, const WorldPos& eye, double within_m) {
    return std::any_of(scene.cells.begin(), scene.cells.end(), [&](const scene::Cell& cell) {
        if (!(distance_to(cell.bounds, eye) < within_m)) return false;
        const auto instances = scene.instances.subspan(cell.first_instance, cell.instance_count);
        return std::any_of(instances.begin(), instances.end(), [&](const scene::Instance& instance) {
            return is_foliage(scene, instance) && distance_to(instance.bounds, eye) < within_m;
        });
    });
}

LeafSway make_leaf_sway(const WorldPos& eye, const scene::Weather& weather, double time_s, float within_m) {
    const DVec3 wind(weather.wind_m_s.x, 0.0, weather.wind_m_s.y);
    const double speed = glm::length(wind);
    if (!(speed >= kLeastWindMS) || !(within_m > 0.0f)) return {};
    const DVec3 along = wind / speed, across(-along.z, 0.0, along.x), up(0.0, 1.0, 0.0);
    constexpr double kGustM = 30.0, kLeafM = 2.3, kMetresPerMS = 0.01, kMostM = 0.1;
    // Directions, lengths and rates that never line up: neighbouring cards move differently, both ways of each alike.
    const DVec3 k_u = (0.8 * along + 0.3 * up + 0.5 * across) / kLeafM;
    const DVec3 k_v = (0.5 * along - 0.4 * up - 0.9 * across) / kLeafM;
    LeafSway sway;
    sway.gust = make_train(along / kGustM, speed / kGustM, eye, time_s);
    sway.along_u = make_train(k_u, 0.83, eye, time_s);
    sway.along_v = make_train(k_v, 1.17, eye, time_s);
    sway.amplitude_m = float(std::min(kMetresPerMS * speed, kMostM));
    sway.within_m = within_m;
    return sway;
}

Decision decide_wind(const Conditions& conditions) {
    const auto blows = [](const scene::Weather& weather) { return glm::length(weather.wind_m_s) >= kLeastWindMS; };
    if (!conditions.facts.has_foliage) return {State::off, "nothing in the scene sways"};
    if (!blows(conditions.environment.weather)) return {State::off, "the air is still"};
    if (!(conditions.wind_within_m > 0.0f)) return {State::off, "switched off"};
    if (conditions.reprojects) return {State::off, "reprojected leaves stand still"};
    if (conditions.by_opengl && !blows(conditions.scene.environment.weather))
        return {State::off, "the rasteriser knows the scene's own wind only"};
    if (std::any_of(conditions.dynamic.begin(), conditions.dynamic.end(),
                    [&](const scene::Instance& instance) { return is_foliage(conditions.scene, instance); }))
        return {State::active, "foliage moves about"};
    if (is_foliage_within(conditions.scene, conditions.eye, conditions.wind_within_m))
        return {State::active, "foliage is near"};
    return {State::idle, "no foliage is near"};
}

}  // namespace ff::effects
