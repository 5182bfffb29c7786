#include "engine/frame/sun_pass.h"

#include <glm/geometric.hpp>

#include "engine/frame/timed_pass.h"

namespace ff::frame {
namespace {

SunLight& made(const scene::StaticScene& scene, std::unique_ptr<SunLight>& sun) {
    if (!sun) sun = std::make_unique<SunLight>(scene);
    return *sun;
}

/// Room for a byte a pixel, never less than before.
std::uint8_t* fit(const farfield::VisibilityBuffer& visibility, ZeroPageVector<std::uint8_t>& plane) {
    const std::size_t count = std::size_t(visibility.stride) * std::size_t(visibility.rows);
    if (plane.size() < count) plane = ZeroPageVector<std::uint8_t>(count);
    return plane.data();
}

}  // namespace

void bound_moving(std::span<const scene::Instance> dynamic, std::vector<farfield::MovingSphere>& out) {
    out.clear();
    for (const scene::Instance& instance : dynamic)
        if (!instance.bounds.is_empty())
            out.push_back({(instance.bounds.low + instance.bounds.high) * 0.5,
                           glm::length(instance.bounds.high - instance.bounds.low) * 0.5});
}

const std::uint8_t* find_sun(const FramePlan& plan, const scene::StaticScene& scene,
                             const farfield::VisibilityBuffer& visibility, std::span<const farfield::TileRequest> tiles,
                             std::unique_ptr<SunLight>& sun, FrameStats& stats) {
    if (!plan.sun_shadows) return nullptr;
    const TimedPass timed(stats, Pass::sun);
    SunLight& light = made(scene, sun);
    std::uint8_t* const seen = fit(visibility, light.seen);
    const Vec3 to_sun = scene.environment.to_sun;
    std::span<const farfield::TileRequest> cast = tiles;
    bound_moving(plan.dynamic, light.moving);
    const farfield::SunHistoryInput input{.view = plan.view,
                                          .visibility = visibility,
                                          .tiles = tiles,
                                          .static_instances = std::uint32_t(scene.instances.size()),
                                          .moving = light.moving,
                                          .to_sun = to_sun,
                                          .refresh_frames = plan.sun_refresh_frames};
    if (plan.reuse_sun) {
        stats.sun_reused += light.history.reuse(input, seen, light.cast);
        cast = light.cast;
    } else {
        light.history.clear();
    }
    stats.sun_rays += light.rays.cast(plan.view, visibility, cast, plan.dynamic, to_sun, seen).rays;
    if (plan.reuse_sun) light.history.commit(input, cast, seen);
    return seen;
}

const std::uint8_t* find_sun_of_panorama(const FramePlan& plan, const scene::StaticScene& scene,
                                         const PinholeView& view, const farfield::VisibilityBuffer& map,
                                         std::span<const farfield::TileRequest> texels, std::unique_ptr<SunLight>& sun,
                                         FrameStats& stats) {
    if (!plan.sun_shadows) return nullptr;
    const TimedPass timed(stats, Pass::sun);
    SunLight& light = made(scene, sun);
    std::uint8_t* const seen = fit(map, light.panorama_seen);
    stats.sun_rays += light.rays.cast(view, map, texels, {}, scene.environment.to_sun, seen).rays;
    return seen;
}

}  // namespace ff::frame
