// Which lamps light a view.

#include "engine/effects/lamp_grid.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/support/worlds.h"

namespace ff::effects {
namespace {

std::vector<scene::Lamp> strewn_lamps(int count, double size_m, std::uint32_t seed) {
    test::Random random(seed);
    std::vector<scene::Lamp> lamps(std::size_t(count), scene::Lamp{});
    for (scene::Lamp& lamp : lamps) {
        lamp.position = {random.in(-size_m, size_m), random.in(0.0, 20.0), random.in(-size_m, size_m)};
        lamp.radius_m = float(random.in(2.0, 30.0));
    }
    return lamps;
}

TEST(LampGrid, finds_exactly_the_lamps_that_are_near_and_may_be_seen) {
    for (const double size_m : {50.0, 800.0, 3e5}) {
        const std::vector<scene::Lamp> lamps = strewn_lamps(600, size_m, std::uint32_t(size_m));
        const LampGrid grid(lamps);
        test::Random random(5);
        std::vector<shading::LampLight> found;
        for (int i = 0; i < 20; ++i) {
            const Camera camera{
                .position = {random.in(-1.2 * size_m, 1.2 * size_m), 2.0, random.in(-1.2 * size_m, 1.2 * size_m)},
                .yaw = random.in(0.0, 2.0 * kPi)};
            const PinholeView view = make_view(camera, 64, 48);
            const double within_m = 0.3 * size_m;
            grid.find_lit(view, -10.0, within_m, found);
            std::size_t near = 0, ahead = 0;
            for (const scene::Lamp& lamp : lamps) {
                const DVec3 apart = lamp.position - camera.position;
                if (glm::length(apart) >= within_m + double(lamp.radius_m)) continue;
                ++near;
                // Some point of the view's axis lies within its reach.
                const DVec3 axis = -DVec3(view.world_from_camera[2]);
                const double along = std::max(0.0, glm::dot(apart, axis));
                ahead += glm::length(apart - along * axis) < double(lamp.radius_m);
            }
            EXPECT_EQ(grid.has_lamp_within(camera.position, within_m), near > 0);
            EXPECT_LE(found.size(), near);
            EXPECT_GE(found.size(), ahead);
            for (std::size_t k = 1; k < found.size(); ++k)
                EXPECT_LE(glm::length(found[k - 1].position), glm::length(found[k].position) * 1.0001f);
        }
    }
}

TEST(LampGrid, lamps_come_on_as_the_sun_sinks) {
    const std::vector<scene::Lamp> lamps(1, scene::Lamp{.position = {0.0, 4.0, -10.0}, .on_below_sun_deg = 3.0f});
    const LampGrid grid(lamps);
    EXPECT_EQ(grid.first_on_below_deg(), 3.0);
    std::vector<shading::LampLight> found;
    float last = 0.0f;
    for (const double elevation_deg : {4.0, 3.0, 2.5, 2.0, 1.5, 1.0, -20.0}) {
        grid.find_lit(make_view({.position = {0, 2, 0}}, 64, 48), elevation_deg, 100.0, found);
        EXPECT_EQ(found.size(), elevation_deg < 3.0 ? 1u : 0u);
        const float strength = found.empty() ? 0.0f : found[0].strength.r;
        EXPECT_GE(strength, last);
        last = strength;
    }
    EXPECT_GT(last, 1.0f);
}

TEST(LampGrid, without_lamps_there_is_nothing) {
    const LampGrid grid({});
    EXPECT_TRUE(grid.is_empty());
    EXPECT_FALSE(grid.has_lamp_within(WorldPos(0.0), 1e6));
    std::vector<shading::LampLight> found;
    grid.find_lit(make_view({}, 64, 48), -90.0, 1e6, found);
    EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace ff::effects
