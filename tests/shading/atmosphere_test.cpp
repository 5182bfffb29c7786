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

/// The sky as encoded, in the middle of a picture that looks along a direction. @return linear again, roughly
Vec3 sky_at(const Day& day, double yaw_deg, double pitch_deg) {
    scene::SceneData world = make_empty_world();
    world.environment = day.environment;
    const PinholeView view =
        make_view({.yaw = radians_of(yaw_deg), .pitch = radians_of(pitch_deg), .vertical_fov = 0.01}, 1, 1);
    const Vec3 c = shading::shade_reference(world.view(), {}, view, 0, 0, farfield::kSkyInstance, 0, INFINITY, {});
    return c * c;
}

TEST(Atmosphere, a_high_sun_is_white_in_a_blue_sky) {
    const Day noon(35.0);  // as in most of the year; so far from the zenith that haze does not whiten it
    const Vec3 sun = noon.environment.sun_radiance, zenith = noon.environment.sky_zenith;
    EXPECT_GT(sun.r, sun.b);
    EXPECT_GT(sun.b, 0.7f * sun.r);
    EXPECT_GT(zenith.b, 1.8f * zenith.r);
    EXPECT_GT(brightness(noon.environment.sky_horizon), brightness(zenith));
    // About the default daylight, which textures are made for.
    const scene::Environment usual;
    EXPECT_NEAR(brightness(sun) / brightness(usual.sun_radiance), 1.0, 0.3);
}

TEST(Atmosphere, a_low_sun_is_red_and_so_is_the_sky_below_it) {
    Day evening(1.0);
    const Vec3 sun = evening.environment.sun_radiance;
    EXPECT_GT(sun.r, 2.0f * sun.g);
    EXPECT_GT(sun.g, 2.0f * sun.b);
    evening.environment.atmosphere.brightness = 0.15f;  // so that pictures do not clip
    shading::light_atmosphere(evening.environment, evening.table);
    const Vec3 sunward = sky_at(evening, 90.0, 4.0), away = sky_at(evening, -90.0, 4.0);
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

}  // namespace
}  // namespace ff::test
