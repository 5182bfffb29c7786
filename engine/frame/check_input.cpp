#include "engine/frame/check_input.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace ff::frame {
namespace {

constexpr double kLeastFov = 1e-4, kGreatestFov = kPi - 1e-4;  // radians; beyond, directions leave float's range
constexpr double kStraightUp = 0.5 * kPi + 1e-6;               // radians; 90 degrees as text may round them

bool is_position(const WorldPos& p) {
    return std::fabs(p.x) <= kMaxCoordinateM && std::fabs(p.y) <= kMaxCoordinateM && std::fabs(p.z) <= kMaxCoordinateM;
}

Status check_camera(const Camera& camera) {
    const WorldPos& p = camera.position;
    if (!is_position(p))
        return bad_input(fmt::format("camera: position ({}, {}, {}); expected metres within {:g} of the origin", p.x,
                                     p.y, p.z, kMaxCoordinateM));
    if (!std::isfinite(camera.yaw)) return bad_input(fmt::format("camera: yaw {}; expected radians", camera.yaw));
    if (!(std::fabs(camera.pitch) <= kStraightUp))
        return bad_input(fmt::format("camera: pitch {}; expected radians in [-pi/2, pi/2]", camera.pitch));
    if (!std::isfinite(camera.roll)) return bad_input(fmt::format("camera: roll {}; expected radians", camera.roll));
    if (!(camera.vertical_fov >= kLeastFov && camera.vertical_fov <= kGreatestFov))
        return bad_input(
            fmt::format("camera: vertical field of view {}; expected radians in (0, pi)", camera.vertical_fov));
    return {};
}

Status check_reprojection(const farfield::ReprojectSettings& settings) {
    if (const float share = settings.surface_share; !(share >= 0.0f && share <= 1.0f))
        return bad_input(fmt::format("settings: reproject.surface_share {}; expected [0, 1]", share));
    const struct {
        const char* name;
        int value, low, high;
    } numbers[] = {{"min_count", settings.min_count, 0, 9},
                   {"resample_period", settings.resample_period, 0, 64},
                   {"resample_block_px", settings.resample_block_px, 1, 32},
                   {"abrupt_frames", settings.abrupt_frames, 1, 64}};
    for (const auto& [name, value, low, high] : numbers)
        if (value < low || value > high)
            return bad_input(fmt::format("settings: reproject.{} {}; expected [{}, {}]", name, value, low, high));
    if (!std::has_single_bit(unsigned(settings.resample_block_px)))
        return bad_input(fmt::format("settings: reproject.resample_block_px {}; expected a power of two",
                                     settings.resample_block_px));
    return {};
}

Status check_settings(const FrameSettings& settings) {
    if (!(settings.budget_ms >= 0.0) || !std::isfinite(settings.budget_ms))
        return bad_input(
            fmt::format("settings: budget_ms {}; expected milliseconds, or 0 for none", settings.budget_ms));
    if (settings.fixed_near_m && (!(*settings.fixed_near_m >= 0.0) || !std::isfinite(*settings.fixed_near_m)))
        return bad_input(fmt::format("settings: fixed_near_m {}; expected metres, [0, inf)", *settings.fixed_near_m));
    if (!(settings.max_parallax_px >= 0.0f && settings.max_parallax_px <= 16.0f))
        return bad_input(
            fmt::format("settings: max_parallax_px {}; expected pixels in [0, 16]", settings.max_parallax_px));
    if (!(settings.prelit_beyond_m >= 0.0f))
        return bad_input(
            fmt::format("settings: prelit_beyond_m {}; expected metres, [0, inf]", settings.prelit_beyond_m));
    if (!(settings.blend_within_m >= 0.0f) || !std::isfinite(settings.blend_within_m))
        return bad_input(
            fmt::format("settings: blend_within_m {}; expected metres, [0, inf)", settings.blend_within_m));
    if (!(settings.grid_cells_per_item > 0.0f && settings.grid_cells_per_item <= 64.0f))
        return bad_input(
            fmt::format("settings: grid_cells_per_item {}; expected (0, 64]", settings.grid_cells_per_item));
    if (!(settings.resolution >= 0.25f && settings.resolution <= 1.0f))
        return bad_input(fmt::format("settings: resolution {}; expected a share in [0.25, 1]", settings.resolution));
    if (!(settings.panorama_density >= 0.25f && settings.panorama_density <= 2.0f))
        return bad_input(fmt::format("settings: panorama_density {}; expected [0.25, 2]", settings.panorama_density));
    if (const int n = settings.horizon_subsample; n != 1 && n != 2 && n != 4)
        return bad_input(fmt::format("settings: horizon_subsample {}; expected 1, 2 or 4", n));
    if (const int n = settings.sun_refresh_frames; n < 0 || n > 255)
        return bad_input(fmt::format("settings: sun_refresh_frames {}; expected [0, 255]", n));
    if (settings.to_sun) {
        const Vec3& sun = *settings.to_sun;
        if (const float length2 = glm::dot(sun, sun); !(length2 > 0.98f && length2 < 1.02f))
            return bad_input(
                fmt::format("settings: to_sun ({}, {}, {}); expected a unit direction", sun.x, sun.y, sun.z));
    }
    if (!(settings.sun_step_rad >= 0.0f && settings.sun_step_rad <= 0.1f))
        return bad_input(fmt::format("settings: sun_step_rad {}; expected radians in [0, 0.1]", settings.sun_step_rad));
    if (settings.weather) {
        const scene::Weather& w = *settings.weather;
        if (!(w.rain >= 0.0f && w.rain <= 1.0f && w.snow >= 0.0f && w.snow <= 1.0f))
            return bad_input(
                fmt::format("settings: weather with rain {} and snow {}; expected [0, 1]", w.rain, w.snow));
        if (!(glm::dot(w.wind_m_s, w.wind_m_s) <= 1e6f))
            return bad_input(
                fmt::format("settings: a wind of ({}, {}) m/s; expected at most 1,000", w.wind_m_s.x, w.wind_m_s.y));
    }
    if (!(std::fabs(settings.time_s) <= 1e9))
        return bad_input(
            fmt::format("settings: time_s {}; expected seconds within a thousand million", settings.time_s));
    if (!(settings.lamps_within_m >= 0.0f && settings.lamps_within_m <= 1e5f))
        return bad_input(
            fmt::format("settings: lamps_within_m {}; expected metres in [0, 100000]", settings.lamps_within_m));
    if (!(settings.air_error >= 0.0f && settings.air_error <= 0.1f))
        return bad_input(
            fmt::format("settings: air_error {}; expected a share of a pixel's range in [0, 0.1]", settings.air_error));
    if (!(settings.water_within_m >= 0.0f && settings.water_within_m <= 1e5f))
        return bad_input(
            fmt::format("settings: water_within_m {}; expected metres in [0, 100000]", settings.water_within_m));
    if (!(settings.wind_within_m >= 0.0f && settings.wind_within_m <= 1000.0f))
        return bad_input(
            fmt::format("settings: wind_within_m {}; expected metres in [0, 1000]", settings.wind_within_m));
    if (!(settings.fall_density >= 0.0f && settings.fall_density <= 1.0f))
        return bad_input(fmt::format("settings: fall_density {}; expected [0, 1]", settings.fall_density));
    if (!(settings.reflections_within_m > 0.0f && settings.reflections_within_m <= 1e5f))
        return bad_input(fmt::format("settings: reflections_within_m {}; expected metres in (0, 100000]",
                                     settings.reflections_within_m));
    return check_reprojection(settings.reproject);
}

Status check_instance(const scene::StaticScene& scene, const scene::Instance& instance, std::size_t number) {
    if (instance.mesh >= scene.meshes.size())
        return bad_input(
            fmt::format("moving instance {}: mesh {}; the scene has {}", number, instance.mesh, scene.meshes.size()));
    const WorldPos& p = instance.position;
    if (!is_position(p))
        return bad_input(
            fmt::format("moving instance {}: position ({}, {}, {}); expected metres within {:g} of the origin", number,
                        p.x, p.y, p.z, kMaxCoordinateM));
    const double volume = glm::determinant(DMat3(instance.world_from_mesh));
    if (!std::isfinite(volume) || volume == 0.0)
        return bad_input(fmt::format(
            "moving instance {}: a transform of volume {}; expected a finite one that is not flat", number, volume));
    const DBox3& box = instance.bounds;
    if (!scene.meshes[instance.mesh].bounds.is_empty() &&
        (box.is_empty() || !is_position(box.low) || !is_position(box.high)))
        return bad_input(fmt::format("moving instance {}: bounds ({}, {}, {}) to ({}, {}, {}); expected a box", number,
                                     box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z));
    return {};
}

}  // namespace

Status check_frame_input(const scene::StaticScene& scene, const Camera& camera,
                         std::span<const scene::Instance> dynamic, const FrameSettings& settings) {
    FF_TRY(check_camera(camera));
    FF_TRY(check_settings(settings));
    for (std::size_t i = 0; i < dynamic.size(); ++i) FF_TRY(check_instance(scene, dynamic[i], i));
    return {};
}

}  // namespace ff::frame
