#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/effects/wind.h"
#include "engine/frame/history.h"
#include "engine/frame/plan.h"
#include "engine/scene/sky_table.h"

namespace ff::frame {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A viewer who moves less than this between frames only turns: even at arm's length it is a hundredth of a pixel.
constexpr double kRestM = 1e-6;
/// Frames to wait after a step before the panorama is filled ahead: a turn is more than a pause between two steps.
constexpr int kRestFrames = 2;

/// Pixels whose panorama texel would still be good after another step like the last one. A texel lives for
/// limit * depth / (f * step) frames before its parallax exceeds the limit; of its life all but the first frame is
/// reuse.
double expected_reusable_pixels(const farfield::VisibilityBuffer& visibility, const PinholeView& view, double step_m,
                                double limit_px) {
    constexpr int kStride = 8;  // every 64th pixel is enough for a share
    double reusable = 0.0;
    for (int y = kStride / 2; y < visibility.height; y += kStride) {
        for (int x = kStride / 2; x < visibility.width; x += kStride) {
            const double depth = visibility.depth[visibility.index(x, y)];
            if (!std::isfinite(depth)) continue;
            const double life_frames = limit_px * depth * view.pixel_angle() / std::max(step_m, 1e-9);
            if (life_frames > 1.0) reusable += 1.0 - 1.0 / life_frames;
        }
    }
    return reusable * kStride * kStride;
}

/// Pixels and triangles that each near distance would take, from the last frame's depths and the cells' distances.
void expect_near_field(const scene::StaticScene& scene, const farfield::VisibilityBuffer& visibility,
                       const WorldPos& eye, budget::Outlook& outlook) {
    outlook.near_pixels = {};
    outlook.near_triangles = {};
    constexpr int kStride = 8;
    for (int y = kStride / 2; y < visibility.height; y += kStride)
        for (int x = kStride / 2; x < visibility.width; x += kStride) {
            const double depth = visibility.depth[visibility.index(x, y)];
            for (std::size_t i = 1; i < budget::kNearDistances.size(); ++i)
                if (depth < budget::kNearDistances[i]) outlook.near_pixels[i] += kStride * kStride;
        }
    for (const scene::Cell& cell : scene.cells) {
        const double distance = distance_to(cell.bounds, eye);
        for (std::size_t i = 1; i < budget::kNearDistances.size(); ++i)
            if (distance < budget::kNearDistances[i]) outlook.near_triangles[i] += double(cell.triangle_count);
    }
}

void look_ahead(const scene::StaticScene& scene, const FramePlan& plan, const FrameSettings& settings,
                FrameHistory& history) {
    // Cells and depths change slowly; the near field's outlook is refreshed a few times a second.
    constexpr std::uint64_t kRefreshFrames = 8;
    budget::Outlook& outlook = history.outlook;
    // All pixels are those of a frame of full size.
    outlook.pixels = double(plan.image_width) * plan.image_height;
    const double enlarged =
        outlook.pixels / std::max(1.0, double(history.visibility.width) * double(history.visibility.height));
    outlook.sky_pixels = double(history.last_stats.pixels.sky) * enlarged;
    outlook.horizon_azimuths = settings.use_horizon ? history.horizon.settings().columns / 4.0 : 0.0;
    const double step_m = glm::length(plan.view.position - history.last_view.position);
    // A moving viewer's texels are off by up to max_parallax_px: worth it only to keep a budget, and if so chosen.
    const bool reuses =
        settings.use_panorama && settings.budget_ms > 0.0 && settings.when_late == budget::WhenLate::stale;
    outlook.reusable_pixels =
        reuses ? enlarged * expected_reusable_pixels(history.visibility, plan.view, step_m, settings.max_parallax_px)
               : 0.0;
    if (history.frame_number % kRefreshFrames == 1) {
        expect_near_field(scene, history.visibility, plan.view.position, outlook);
        for (double& pixels : outlook.near_pixels) pixels *= enlarged;
    }
}

void decide_effects(const scene::StaticScene& scene, const effects::SceneFacts& facts, const FrameSettings& settings,
                    FramePlan& plan) {
    using effects::EffectId, effects::State;
    const auto sun_shadows = settings.sun_shadows == SunShadows::by_scene
                                 ? std::nullopt
                                 : std::optional(settings.sun_shadows == SunShadows::on);
    plan.effects = effects::decide_effects({.scene = scene,
                                            .environment = plan.environment,
                                            .facts = facts,
                                            .dynamic = plan.dynamic,
                                            .eye = plan.view.position,
                                            .by_opengl = plan.mode == Mode::raster || plan.mode == Mode::near,
                                            .reprojects = plan.mode == Mode::reproject,
                                            .sun_shadows = sun_shadows,
                                            .blend_within_m = settings.blend_within_m,
                                            .lamps_within_m = settings.lamps_within_m,
                                            .reflection_rays = settings.reflection_rays,
                                            .reflections_within_m = settings.reflections_within_m,
                                            .water_within_m = settings.water_within_m,
                                            .wind_within_m = settings.wind_within_m,
                                            .hearing = settings.hearing,
                                            .simulations = settings.simulations,
                                            .without = settings.without_effects});
    scene::Weather& weather = plan.environment.weather;
    if (!plan.effects.is_active(EffectId::rain)) weather.rain = 0.0f;
    if (!plan.effects.is_active(EffectId::snow)) weather.snow = 0.0f;
    const scene::SkyTable* const sky = plan.environment.sky;
    plan.fall = {.weather = weather,
                 .time_s = settings.time_s,
                 .density = settings.fall_density,
                 // White in the light from the side, or the painted sky's colour at the horizon.
                 .light = sky != nullptr ? sky->light_side : plan.environment.sky_horizon,
                 .by_film = sky != nullptr && plan.environment.panorama_width == 0};
    plan.lamps_within_m = plan.effects.is_active(EffectId::lamps) ? settings.lamps_within_m : 0.0f;
    plan.air_error = settings.air_error;
    plan.water_within_m = plan.effects[EffectId::water].state != State::off ? settings.water_within_m : 0.0f;
    if (plan.effects.is_active(EffectId::reflections)) plan.reflection_rays = settings.reflection_rays;
    plan.reflections_within_m = settings.reflections_within_m;
    plan.sun_elevation_deg = degrees_of(std::asin(std::clamp(double(plan.environment.to_sun.y), -1.0, 1.0)));
    if (!plan.effects.is_active(EffectId::fog)) plan.environment.fog_density_per_m = 0.0f;
    // Casters look past blended surfaces that are drawn as layers, also where none is near.
    const bool has_layers = plan.effects[EffectId::transparency].state != State::off;
    plan.view.blend_within_m = has_layers ? settings.blend_within_m : 0.0f;
    plan.sun_shadows = plan.effects.is_active(EffectId::sun_shadows);
    if (plan.effects.is_active(EffectId::wind))
        plan.view.sway = effects::make_leaf_sway(plan.view.position, weather, settings.time_s, settings.wind_within_m);
}

/// Draws the frame at a share of the image's sides. Whole pixels, at least one.
void reduce(const Camera& camera, double resolution, FramePlan& plan) {
    const auto scaled = [&](int pixels) { return std::max(1, int(std::lround(resolution * pixels))); };
    const PinholeView planned = plan.view;
    plan.view = make_view(camera, scaled(plan.image_width), scaled(plan.image_height));
    plan.view.blend_within_m = planned.blend_within_m;
    plan.view.sway = planned.sway;
}

/// A budget is kept by drawing smaller, and who rests gets the panorama, which makes frames cheaper than any other.
void use_panorama_or_draw_smaller(const FrameSettings& settings, const budget::Choice& choice, const Camera& camera,
                                  bool rests, const FrameHistory& history, FramePlan& plan) {
    double resolution = std::min(choice.resolution, double(settings.resolution));
    // Tiles where leaves move are cast in each frame, at full size: worth it where that fits, too.
    const bool leaves_fit = history.swaying_share * choice.needed_rays <= choice.affordable_rays;
    if (rests && leaves_fit) {
        plan.fill_panorama = true;
        plan.look_up_panorama = history.panorama_is_full;
        if (plan.look_up_panorama) return;
        // Until the map holds all that is seen, it is filled with what time is left, and a quarter of it at least.
        constexpr double kLeastFill = 0.25;
        const double fill = std::max(choice.affordable_rays - choice.needed_rays, kLeastFill * choice.affordable_rays);
        plan.fill_budget = std::uint64_t(fill);
        resolution =
            std::min(resolution, std::sqrt((choice.affordable_rays - fill) / std::max(1.0, choice.needed_rays)));
        resolution = std::max(resolution, budget::kResolutions.back());
    }
    if (resolution < settings.resolution) reduce(camera, resolution, plan);
}

/// What the panorama does for the frame, and where it cannot help, how large the frame is drawn.
void use_panorama(const FrameSettings& settings, const budget::Choice& choice, const Camera& camera,
                  const FrameHistory& history, FramePlan& plan) {
    const int face_size = history.panorama ? history.panorama->settings().face_size
                                           : farfield::Panorama::face_size_for(plan.view, settings.panorama_density);
    const bool is_sharp = !farfield::Panorama::is_too_coarse(face_size, plan.view, settings.panorama_density);
    const bool may_use = settings.use_panorama && is_sharp;
    const bool rests = may_use && history.rest_frames >= kRestFrames;
    if (!history.has_frame) {
        plan.fill_panorama = rests;
        return;
    }
    if (settings.budget_ms > 0.0 && settings.when_late == budget::WhenLate::coarser && !settings.reuse_while_moving)
        return use_panorama_or_draw_smaller(settings, choice, camera, rests, history, plan);
    plan.fill_panorama = rests;
    const bool reuses_while_moving =
        settings.reuse_while_moving || (settings.budget_ms > 0.0 && choice.look_up_panorama);
    plan.look_up_panorama = may_use && (reuses_while_moving || plan.fill_panorama);
    // A frame that nearly fills its budget is remembered, for the next may not fit.
    constexpr double kTightShare = 0.6;
    const bool tight = settings.budget_ms > 0.0 && choice.predicted_ms > kTightShare * settings.budget_ms;
    plan.store_panorama = may_use && !plan.fill_panorama && (plan.look_up_panorama || tight);
}

/// Light comes from the sun's place, and clouds with what falls.
void light_plan(const FrameSettings& settings, FrameHistory& history, scene::Environment& environment) {
    const scene::Weather weather = environment.weather;
    if ((settings.without_effects & effects::set_of(effects::EffectId::rain)) != 0) environment.weather.rain = 0.0f;
    if ((settings.without_effects & effects::set_of(effects::EffectId::snow)) != 0) environment.weather.snow = 0.0f;
    history.daylight.light(environment);
    environment.weather = weather;
}

}  // namespace

void plan_frame(const scene::StaticScene& scene, const effects::SceneFacts& facts,
                std::span<const scene::Instance> dynamic, const Camera& camera, int width, int height,
                const FrameSettings& settings, FrameHistory& history, FramePlan& plan) {
    plan = {};
    plan.mode = settings.mode;
    plan.image_width = width;
    plan.image_height = height;
    reduce(camera, settings.resolution, plan);
    plan.dynamic = dynamic;
    plan.environment = scene.environment;
    if (settings.to_sun) plan.environment.to_sun = effects::rounded_sun(*settings.to_sun, settings.sun_step_rad);
    if ((settings.without_effects & effects::set_of(effects::EffectId::atmosphere)) != 0)
        plan.environment.atmosphere = {};
    if (settings.weather) plan.environment.weather = *settings.weather;
    light_plan(settings, history, plan.environment);
    decide_effects(scene, facts, settings, plan);
    plan.caster = settings.caster;
    plan.grid_cells_per_item = settings.grid_cells_per_item;
    plan.max_parallax_px = settings.max_parallax_px;
    plan.panorama_density = settings.panorama_density;
    plan.panorama_edges = settings.panorama_edges;
    plan.keep_ids = settings.keep_ids;
    plan.horizon_subsample = settings.horizon_subsample;
    plan.prelit_beyond_m = settings.prelit_beyond_m;
    plan.sun_refresh_frames = settings.sun_refresh_frames;
    plan.reuse_sun =
        plan.sun_shadows && settings.reuse_sun && (settings.mode == Mode::hybrid || settings.mode == Mode::beam_reuse);

    switch (settings.mode) {
        case Mode::raster:
            plan.rasterise = true;
            plan.near_m = kInfinity;
            return;
        case Mode::near:
            plan.rasterise = true;
            plan.near_m = settings.fixed_near_m.value_or(100.0);
            return;
        case Mode::raycast:
            plan.caster = CasterKind::embree;
            return;
        case Mode::beam:
        case Mode::beam_reuse:
            plan.caster = CasterKind::beam;
            plan.trace_horizon = settings.use_horizon && scene.height_grid.size > 0;
            return;
        case Mode::irsa:
            plan.caster = CasterKind::embree;
            plan.primitives_are_known = true;
            return;
        case Mode::reproject:
            plan.caster = settings.reproject_caster;
            plan.reproject = settings.reproject;
            plan.may_reproject = history.has_frame && knows_primitives(history.last_mode) &&
                                 history.visibility.width == plan.view.width &&
                                 history.visibility.height == plan.view.height;
            return;
        case Mode::hybrid:
            break;
    }

    const bool moved = glm::length(plan.view.position - history.last_view.position) > kRestM;
    // Who has just arrived stands until he moves; his panorama is filled while he still waits for the first picture.
    history.rest_frames = !history.has_frame ? kRestFrames : moved ? 0 : history.rest_frames + 1;
    plan.trace_horizon = settings.use_horizon && scene.height_grid.size > 0;

    budget::Choice choice;
    if (history.has_frame) {
        look_ahead(scene, plan, settings, history);
        choice = history.governor.choose(history.outlook, settings.deterministic ? budget::CostModel{} : history.costs,
                                         settings.budget_ms, settings.when_late);
    }
    plan.near_m = history.can_rasterise ? settings.fixed_near_m.value_or(choice.near_m) : 0.0;
    plan.rasterise = plan.near_m > 0.0;
    plan.software_opacity = settings.opacity == OpacityKind::software;
    plan.ray_budget = std::min(choice.ray_budget, settings.ray_budget);
    plan.predicted_ms = choice.predicted_ms;
    use_panorama(settings, choice, camera, history, plan);
    // A skyline that eats a tenth of the budget is subsampled, conservatively (P0 section 6).
    const double horizon_ms = history.costs.horizon_azimuth.ms_for(history.outlook.horizon_azimuths);
    if (settings.budget_ms > 0.0 && horizon_ms > 0.1 * settings.budget_ms && !settings.deterministic)
        plan.horizon_subsample = std::max(2, plan.horizon_subsample);
}

std::string to_text(const FramePlan& plan) {
    constexpr const char* kModes[] = {"hybrid", "raster", "raycast", "near", "beam", "reproject", "irsa", "beam-reuse"};
    constexpr const char* kCasters[] = {"beam", "embree", "grid"};
    std::string text = fmt::format("mode {}\nnear field {}, {} m\nhorizon {}, every {} azimuths\n",
                                   kModes[int(plan.mode)], plan.rasterise ? "rasterised" : "none", plan.near_m,
                                   plan.trace_horizon ? "traced" : "off", plan.horizon_subsample);
    text += fmt::format("panorama {}{}, up to {} px\n", plan.look_up_panorama ? "looked up" : "not used",
                        plan.fill_panorama ? " and filled ahead" : "", plan.max_parallax_px);
    if (plan.view.blend_within_m > 0.0f)
        text += fmt::format("blended surfaces sorted within {} m\n", plan.view.blend_within_m);
    if (plan.view.width != plan.image_width || plan.view.height != plan.image_height)
        text += fmt::format("drawn {}x{}, shown {}x{}\n", plan.view.width, plan.view.height, plan.image_width,
                            plan.image_height);
    if (plan.sun_shadows)
        text += fmt::format("sun shadows{}\n", plan.reuse_sun ? ", of the last frame where they hold" : "");
    if (!plan.view.sway.is_none()) text += fmt::format("leaves move within {} m\n", plan.view.sway.within_m);
    if (plan.reflection_rays > 0) text += fmt::format("reflections by about {} rays\n", plan.reflection_rays);
    text += plan.ray_budget == UINT64_MAX ? std::string("rays as many as needed")
                                          : fmt::format("rays at most {}", plan.ray_budget);
    return text + fmt::format(" by {}\n", kCasters[int(plan.caster)]);
}

}  // namespace ff::frame
