// A sun that moves.

#include "engine/effects/daylight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/math/types.h"

namespace ff::effects {
namespace {

Vec3 sun_at(double azimuth_deg, double elevation_deg) {
    const double a = radians_of(azimuth_deg), e = radians_of(elevation_deg);
    return Vec3(std::cos(e) * std::sin(a), std::sin(e), -std::cos(e) * std::cos(a));
}

TEST(Daylight, a_sun_is_rounded_to_steps_that_depend_on_nothing_else) {
    const float step = float(radians_of(0.25));
    Vec3 last(0.0f);
    int changes = 0;
    for (double elevation = 10.0; elevation < 15.0; elevation += 0.01) {
        const Vec3 sun = sun_at(200.0 + elevation, elevation), rounded = rounded_sun(sun, step);
        EXPECT_NEAR(glm::length(rounded), 1.0f, 1e-5f);
        EXPECT_LT(glm::length(rounded - sun), 0.75f * step);
        EXPECT_EQ(rounded_sun(sun, step), rounded);
        changes += rounded != last;
        last = rounded;
    }
    EXPECT_LE(changes, 45) << "20 steps up and as many to the side";
    EXPECT_EQ(rounded_sun(sun_at(33.0, 7.0), 0.0f), sun_at(33.0, 7.0));
}

TEST(Daylight, the_table_is_made_once_a_position) {
    Daylight daylight;
    scene::Environment environment;
    environment.atmosphere.turbidity = 2.0f;
    for (int i = 0; i < 3; ++i) daylight.light(environment);
    EXPECT_EQ(daylight.made(), 1u);
    ASSERT_NE(environment.sky, nullptr);
    environment.to_sun = sun_at(90.0, 3.0);
    daylight.light(environment);
    EXPECT_EQ(daylight.made(), 2u);
    EXPECT_GT(environment.sun_radiance.r, environment.sun_radiance.b);
}

TEST(Daylight, a_painted_sky_stays_and_takes_nothing) {
    Daylight daylight;
    scene::Environment environment;
    const Vec3 zenith = environment.sky_zenith, sun = environment.sun_radiance;
    daylight.light(environment);
    EXPECT_EQ(environment.sky, nullptr);
    EXPECT_EQ(environment.sky_zenith, zenith);
    EXPECT_EQ(environment.sun_radiance, sun);
    EXPECT_EQ(daylight.made(), 0u);
    environment.to_sun = sun_at(0.0, -5.0);
    daylight.light(environment);
    EXPECT_EQ(environment.sun_radiance, Vec3(0.0f)) << "it has set";
}

}  // namespace
}  // namespace ff::effects
