#include "engine/nearfield/occlusion_split.h"

#include <cmath>

namespace ff::nearfield {
namespace {

const scene::Instance& instance_of(const scene::StaticScene& scene, const DrawSet& set, std::uint32_t id) {
    return id < scene.instances.size() ? scene.instances[id] : set.dynamic[id - scene.instances.size()];
}

/// An occluder is at least so large for its distance; smaller ones hide little.
constexpr double kOccluderSize = 0.5;
/// All occluders together take at most this share of the set's triangles.
constexpr double kOccluderShare = 0.25;

}  // namespace

bool OcclusionSplit::pays(const scene::StaticScene& scene, const DrawSet& set, const OcclusionSettings& settings) {
    if (!settings.enabled) return false;
    // What the last split saved was known only after it.
    if (set_triangles_ > 0 && hidden_triangles_ < settings.price_triangles) {
        pause_ = kPauseFrames;
        set_triangles_ = 0;
    }
    if (pause_ > 0) {
        --pause_;
        return false;
    }
    set_triangles_ = 0;
    for (const std::uint32_t id : set.instances)
        set_triangles_ += scene.meshes[instance_of(scene, set, id).mesh].triangle_count;
    if (set_triangles_ >= 2 * settings.price_triangles) return true;
    set_triangles_ = 0;
    return false;
}

bool OcclusionSplit::split(const scene::StaticScene& scene, const DrawSet& set, const WorldPos& camera,
                           const OcclusionSettings& settings) {
    if (!pays(scene, set, settings)) return false;
    choose_occluders(scene, set, camera);
    hidden_triangles_ = 0;
    return !first_.empty() && !rest_.empty();
}

void OcclusionSplit::choose_occluders(const scene::StaticScene& scene, const DrawSet& set, const WorldPos& camera) {
    first_.clear();
    rest_.clear();
    auto left = std::int64_t(kOccluderShare * double(set_triangles_));
    for (const std::uint32_t id : set.instances) {
        const scene::Instance& instance = instance_of(scene, set, id);
        const std::int64_t triangles = scene.meshes[instance.mesh].triangle_count;
        const DVec3 extent = instance.bounds.extent();
        const double size = std::sqrt(extent.x * extent.x + extent.y * extent.y + extent.z * extent.z);
        if (triangles <= left && size >= kOccluderSize * distance_to(instance.bounds, camera)) {
            left -= triangles;
            first_.push_back(id);
        } else {
            rest_.push_back(id);
        }
    }
}

void OcclusionSplit::test_rest(const scene::StaticScene& scene, const DrawSet& set,
                               const visibility::OcclusionBuffer& buffer) {
    survivors_.clear();
    hidden_triangles_ = 0;
    std::uint32_t tested_cell = ~0u;
    bool cell_is_hidden = false;
    for (const std::uint32_t id : rest_) {
        const scene::Instance& instance = instance_of(scene, set, id);
        const bool moves = id >= scene.instances.size();
        if (!moves && instance.cell != tested_cell) {
            tested_cell = instance.cell;
            cell_is_hidden = buffer.is_hidden(scene.cells[tested_cell].bounds);
        }
        if ((!moves && cell_is_hidden) || buffer.is_hidden(instance.bounds))
            hidden_triangles_ += scene.meshes[instance.mesh].triangle_count;
        else
            survivors_.push_back(id);
    }
}

}  // namespace ff::nearfield
