#include "engine/frame/shade_settings.h"

#include <algorithm>

#include "engine/frame/timed_pass.h"

namespace ff::frame {
namespace {

/// Weak rain wets all the ground, and so does weak snow whiten it: they have fallen for a while.
constexpr float kWetPerRain = 3.0f;
constexpr float kCoverPerSnow = 2.0f;

}  // namespace

shading::ShadeSettings shade_settings(const FramePlan& plan, const Tools& tools, const PinholeView& view,
                                      const std::uint8_t* sun_seen, ViewLights& lights, FrameStats& stats,
                                      const shading::Reflections* reflections) {
    lights.lamps.clear();
    if (plan.lamps_within_m > 0.0f) {
        const TimedEffect timed(stats, effects::EffectId::lamps);
        tools.facts.lamps->find_lit(view, plan.sun_elevation_deg, plan.lamps_within_m, lights.lamps);
    }
    const scene::Weather& weather = plan.environment.weather;
    // Also where none is near enough to have them: there it is as rough.
    const bool has_waves = plan.effects[effects::EffectId::water].state != effects::State::off;
    if (has_waves) lights.waves = shading::make_waves(view.position, weather, plan.fall.time_s);
    return {.prelit_beyond_m = plan.prelit_beyond_m,
            .sun_seen = sun_seen,
            .lamps = lights.lamps,
            .waves = has_waves ? &lights.waves : nullptr,
            .waves_within_m = plan.water_within_m,
            .reflections = reflections,
            .wet = std::min(1.0f, kWetPerRain * weather.rain),
            .snow_cover = std::min(1.0f, kCoverPerSnow * weather.snow),
            .air_error = plan.air_error};
}

}  // namespace ff::frame
