#include "tools/report/frame_work.h"

#include "engine/effects/registry.h"

namespace ff::report {

static_assert(budget::kWorkKeys[kAllocations] == "allocations");

FrameWork work_of(const frame::FrameStats& stats, std::uint64_t allocations, std::uint64_t upload_bytes) {
    // Rays towards the sun are in sun_rays and again in its effect's work.
    std::uint64_t rays = stats.rays + stats.sun_rays;
    for (const effects::Effect& effect : effects::registry())
        if (effect.id != effects::EffectId::sun_shadows) rays += stats.work(effect.id).rays;
    const farfield::ReprojectCounts& points = stats.causes;
    return {rays,
            stats.near_triangles,
            points.verified + points.background + points.failed,
            stats.pixels.panorama,
            stats.shaded_pixels,
            stats.layers,
            allocations,
            upload_bytes};
}

std::span<const std::string_view> effect_names() {
    static const auto names = [] {
        std::array<std::string_view, effects::kEffectCount> all;
        for (const effects::Effect& effect : effects::registry()) all[std::size_t(effect.id)] = effect.name;
        return all;
    }();
    return names;
}

}  // namespace ff::report
