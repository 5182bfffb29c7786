// What light and sky of an atmosphere do as the sun climbs and sets.

#include "engine/shading/atmosphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/shading/shade_reference.h"
#include "engine/shading/shading_model.h"
#include "tests/support/worlds.h"

namespace ff::test {
namespace {

/// Light of an atmosphere whose sun stands over the east.
struct Day {
    scene::SkyTable table;
    scene::Environment environment;

    explicit Day(double elevation_deg, float turbidity = 2.0f) {
        const double e = radians_of(elevation_deg);
        environment.to_sun = Vec3(std::cos(e), std::sin(e), 0.0);
        environment.atmosphere.turbidity = turbidity;
        shading::light_atmosphere(environment, table);
    }
};

double brightness(const Vec3& c) {
    return double(glm::dot(c, Vec3(0.2126f, 0.7152f, 0.0722f)));
}

/// The sky in the middle of a picture that looks along a direction, as pixels hold it.
Vec3 encoded_sky_at(const Day& day, double yaw_deg, double pitch_deg, bool plain_srgb = false) {
    scene::SceneData world = make_empty_world();
    world.environment = day.environment;
    const PinholeView view =
        make_view({.yaw = radians_of(yaw_deg), .pitch = radians_of(pitch_deg), .vertical_fov = 0.01}, 1, 1);
    return shading::shade_reference(world.view(), {}, view, 0, 0, farfield::kSkyInstance, 0, INFINITY,
                                    {.plain_srgb = plain_srgb});
}

/// Its light, without what the picture does to show it.
Vec3 linear_sky_at(const Day& day, double yaw_deg, double pitch_deg) {
    Vec3 light = encoded_sky_at(day, yaw_deg, pitch_deg, true);
    for (int k = 0; k < 3; ++k) {
        const float c = light[k];
        const float shown = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
        light[k] = std::sqrt(1.0f - 2.0f * std::log(1.0f - shown)) - 1.0f;  // 1 - exp(-x - x^2 / 2)
    }
    return light;
}

TEST(Atmosphere, a_high_sun_is_white_in_a_blue_sky) {
    const Day noon(35.0);  // as in most of the year; so far from the zenith that haze does not whiten it
    const Vec3 sun = noon.environment.sun_radiance, zenith = noon.environment.sky_zenith;
    EXPECT_GT(sun.r, sun.b);
    EXPECT_GT(sun.b, 0.7f * sun.r);
    EXPECT_GT(zenith.b, 1.8f * zenith.r);
    EXPECT_GT(brightness(noon.environment.sky_horizon), brightness(zenith));
    // Level ground is about as bright as by the default daylight, which textures are made for.
    const auto on_ground = [](const scene::Environment& environment) {
        const shading::ShadingUniforms u = shading::make_uniforms(environment, make_view({}, 1, 1));
        return brightness(Vec3(u.ambient_side + u.ambient_slope + u.ambient_curve)) +
               brightness(environment.sun_radiance) * double(environment.to_sun.y);
    };
    EXPECT_NEAR(on_ground(noon.environment) / on_ground({}), 1.0, 0.3);
}

TEST(Atmosphere, a_low_sun_is_red_and_so_is_the_sky_below_it) {
    Day evening(1.0);
    const Vec3 sun = evening.environment.sun_radiance;
    EXPECT_GT(sun.r, 2.0f * sun.g);
    EXPECT_GT(sun.g, 2.0f * sun.b);
    evening.environment.atmosphere.brightness = 0.15f;  // so that pictures do not saturate
    shading::light_atmosphere(evening.environment, evening.table);
    const Vec3 sunward = linear_sky_at(evening, 90.0, 4.0), away = linear_sky_at(evening, -90.0, 4.0);
    EXPECT_GT(sunward.r / sunward.b, away.r / away.b);
    EXPECT_GT(brightness(sunward), brightness(away));
}

TEST(Atmosphere, haze_whitens_and_dims) {
    const Day clear(40.0, 1.2f), hazy(40.0, 6.0f);
    EXPECT_LT(brightness(hazy.environment.sun_radiance), brightness(clear.environment.sun_radiance));
    const Vec3 a = clear.environment.sky_zenith, b = hazy.environment.sky_zenith;
    EXPECT_GT(a.b / a.r, b.b / b.r);
    EXPECT_GT(hazy.table.mie_per_m.g, 10.0f * clear.table.mie_per_m.g);
}

TEST(Atmosphere, brightness_sinks_smoothly_with_the_sun_and_night_is_dark_but_not_black) {
    double last = 1e9;
    for (double elevation = 60.0; elevation >= -20.0; elevation -= 0.5) {
        const Day day(elevation);
        const shading::ShadingUniforms u = shading::make_uniforms(day.environment, make_view({}, 1, 1));
        const double lit = brightness(Vec3(u.ambient_side + u.ambient_slope + u.ambient_curve)) +
                           brightness(day.environment.sun_radiance) * std::max(0.0, double(day.environment.to_sun.y));
        EXPECT_LE(lit, last * 1.02) << elevation;
        if (last < 1e9) {
            EXPECT_GE(lit, last * 0.85) << elevation;
        }
        last = lit;
        if (elevation < -0.5) {
            EXPECT_EQ(day.environment.sun_radiance, Vec3(0.0f)) << elevation;
        }
        for (const auto& row : day.table.rows)
            for (int k = 0; k < 3; ++k)
                ASSERT_TRUE(std::isfinite(row.rayleigh[k] + row.rayleigh_sunward[k] + row.mie[k] + row.mie_sunward[k]));
    }
    EXPECT_GT(last, 0.02);
    EXPECT_LT(last, 0.2);
}

TEST(Atmosphere, what_stands_far_away_at_eye_level_fades_into_the_sky_behind_it) {
    for (const double elevation : {50.0, 5.0, -3.0}) {
        const Day day(elevation);
        scene::SceneData world = make_single_triangle({-4e5f, -4e5f, 0}, {4e5f, -4e5f, 0}, {0, 8e5f, 0});
        world.environment = day.environment;
        const PinholeView view = make_view({.position = {0, 0, 9e5}, .vertical_fov = 0.001}, 1, 1);
        const Vec3 wall = shading::shade_reference(world.view(), {}, view, 0, 0, 0, 0, 9e5f, {});
        const Vec3 sky =
            shading::shade_reference(world.view(), {}, view, 0, 0, farfield::kSkyInstance, 0, INFINITY, {});
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(wall[k], sky[k], 1.0 / 255.0) << elevation;
        // Near by it has its own colour.
        const PinholeView near_view = make_view({.position = {0, 0, 10}, .vertical_fov = 0.001}, 1, 1);
        const Vec3 close = shading::shade_reference(world.view(), {}, near_view, 0, 0, 0, 0, 10.0f, {});
        EXPECT_GT(glm::length(close - sky), 0.02f) << elevation;
    }
}

TEST(Atmosphere, a_clear_noon_has_the_light_that_is_measured_on_earth) {
    for (const double elevation : {35.0, 48.0, 60.0}) {
        const Day noon(elevation, 1.8f);
        const double sun = brightness(noon.environment.sun_radiance) * double(noon.environment.to_sun.y);
        const double sky = brightness(noon.table.light_up);
        // A clear sky gives an eighth to a third of the light on level ground, shadows are four to eight times darker.
        EXPECT_GT(sky / (sun + sky), 0.12) << elevation;
        EXPECT_LT(sky / (sun + sky), 0.30) << elevation;
        // Blue as between 15,000 and 30,000 K: in linear sRGB that is 2.2 to 3 times as much blue as red. Away from the
        // sun, where its glow does not whiten it.
        const Vec3 high = linear_sky_at(noon, -90.0, 60.0);
        EXPECT_GT(high.b / high.r, 2.2f) << elevation;
        EXPECT_LT(high.b / high.r, 3.2f) << elevation;
        // As bright as ground of an albedo between 0.1 and 0.4 in the sun.
        EXPECT_GT(brightness(high) / (sun + sky), 0.06) << elevation;
        EXPECT_LT(brightness(high) / (sun + sky), 0.4) << elevation;
    }
}

TEST(Atmosphere, a_clear_noon_is_shown_in_blue) {
    const Day noon(48.0, 1.8f);
    for (const double pitch : {20.0, 45.0, 70.0}) {
        const Vec3 shown = encoded_sky_at(noon, 0.0, pitch);
        EXPECT_GT(shown.b - shown.r, 60.0f / 255.0f) << pitch;
        EXPECT_GT(shown.b, 140.0f / 255.0f) << pitch;
    }
}

TEST(Atmosphere, at_sunset_the_horizon_across_the_sky_still_has_light) {
    const Day sunset(0.0);
    const Vec3 across = linear_sky_at(sunset, -90.0, 0.5), above = linear_sky_at(sunset, -90.0, 45.0);
    EXPECT_GT(brightness(across), 0.2 * brightness(above)) << "of light that was scattered more than once";
}

TEST(Atmosphere, clouds_close_the_sky_where_rain_or_snow_falls) {
    const Day clear(40.0);
    for (const bool snows : {false, true}) {
        Day day(40.0);
        (snows ? day.environment.weather.snow : day.environment.weather.rain) = 0.8f;
        shading::light_atmosphere(day.environment, day.table);
        EXPECT_EQ(day.environment.sun_radiance, Vec3(0.0f));
        const Vec3 zenith = linear_sky_at(day, 0.0, 89.0), low = linear_sky_at(day, 0.0, 5.0);
        EXPECT_LT(zenith.b / zenith.r, 1.3f);
        EXPECT_GT(brightness(zenith), 2.0 * brightness(low)) << "as measured under closed skies";
        const double sun = brightness(clear.environment.sun_radiance) * double(clear.environment.to_sun.y);
        EXPECT_LT(brightness(day.table.light_up), 0.8 * (sun + brightness(clear.table.light_up)));
        EXPECT_GT(brightness(day.table.light_up), 0.4 * (sun + brightness(clear.table.light_up)));
    }
}

}  // namespace
}  // namespace ff::test
