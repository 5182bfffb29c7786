#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/physics/physics_worlds.h"
#include "tests/support/town.h"

namespace ff::test {
namespace {

using physics::CharacterId;
using physics::CharacterState;

double level_distance(const WorldPos& a, const WorldPos& b) {
    return std::hypot(a.x - b.x, a.z - b.z);
}

TEST(Character, falls_to_the_floor_and_stands_ten_minutes_without_drift) {
    Walled w(Ground().floor(4).finish());
    const CharacterId id = w.walker({0.3, 1.0, 0.4});
    w.walk(id, Vec3(0.0f), 120);
    const CharacterState landed = w.world.character(id);
    ASSERT_TRUE(landed.on_ground);
    EXPECT_NEAR(landed.position.y, 0.0, 1e-5);
    w.walk(id, Vec3(0.0f), 10 * 60 * 120);
    const CharacterState later = w.world.character(id);
    EXPECT_LT(glm::length(later.position - landed.position), 1e-6);
    EXPECT_EQ(later.velocity_m_s, Vec3(0.0f));
}

TEST(Character, stands_on_any_walkable_slope_without_drift) {
    for (const double slope : {5.0, 20.0, 35.0, 45.0}) {
        Walled w(Ground().ramp(slope, 30).finish());
        const double x = 10.0, y = x * std::tan(radians_of(slope));
        const CharacterId id = w.walker({x, y + 0.5, 0});
        w.walk(id, Vec3(0.0f), 240);
        const CharacterState landed = w.world.character(id);
        ASSERT_TRUE(landed.on_ground) << slope;
        w.walk(id, Vec3(0.0f), 60 * 120);
        EXPECT_LT(glm::length(w.world.character(id).position - landed.position), 1e-5) << slope;
    }
}

TEST(Character, walks_up_slopes_to_the_limit_and_not_beyond) {
    for (const double slope : {10.0, 30.0, 45.0, 55.0, 65.0, 80.0}) {
        Walled w(Ground().floor(12).ramp(slope, 30).finish());
        const CharacterId id = w.walker({-2, 0.1, 0});
        w.walk(id, Vec3(3, 0, 0), 3 * 120);
        const CharacterState c = w.world.character(id);
        if (slope < 49.0) {
            EXPECT_GT(c.position.x, 5.0) << slope;
            EXPECT_GT(c.position.y, 4.0 * std::tan(radians_of(slope))) << slope;
        } else {
            EXPECT_LT(c.position.y, 0.3) << slope;
            EXPECT_LT(c.position.x, 0.6) << slope;
        }
    }
}

TEST(Character, slides_down_what_is_too_steep) {
    for (const double slope : {55.0, 65.0, 75.0}) {
        Walled w(Ground().ramp(slope, 60).finish());
        const double x = 20.0 * std::cos(radians_of(slope)), y = 20.0 * std::sin(radians_of(slope));
        const CharacterId id = w.walker({x, y + 0.5, 0});
        w.walk(id, Vec3(0.0f), 120);
        EXPECT_LT(w.world.character(id).position.y, y - 1.5) << slope;
    }
}

TEST(Character, climbs_stairs_and_follows_them_down) {
    for (const float rise : {0.1f, 0.18f, 0.3f, 0.38f}) {
        Walled w(Ground().floor(20).stairs(12, rise, 0.3f).finish());
        const CharacterId id = w.walker({-1, 0.05, 0});
        w.walk(id, Vec3(2, 0, 0), 4 * 120);
        const CharacterState top = w.world.character(id);
        EXPECT_NEAR(top.position.y, 12 * double(rise), 1e-3) << rise;
        EXPECT_TRUE(top.on_ground);
        // Down: it never leaves the ground, and falls no faster than the stairs do.
        ASSERT_TRUE(w.world.set_input(id, {.velocity_m_s = {-2, 0, 0}}));
        int in_air = 0;
        for (int i = 0; i < 5 * 120; ++i) {
            w.world.step();
            in_air += w.world.character(id).on_ground ? 0 : 1;
        }
        EXPECT_NEAR(w.world.character(id).position.y, 0.0, 1e-3) << rise;
        EXPECT_EQ(in_air, 0) << rise;
    }
}

TEST(Character, does_not_climb_a_step_that_is_too_high) {
    Walled w(Ground().floor(10).box({1, 0, -5}, {6, 0.6f, 5}).finish());
    const CharacterId id = w.walker({-1, 0.05, 0});
    w.walk(id, Vec3(3, 0, 0), 240);
    EXPECT_LT(w.world.character(id).position.x, 0.7);
    EXPECT_NEAR(w.world.character(id).position.y, 0.0, 1e-3);
}

TEST(Character, keeps_its_speed_over_inner_edges) {
    Walled w(Ground().floor(40).finish());
    for (int direction = 0; direction < 12; ++direction) {
        const double angle = 0.1 + direction * kPi / 6.0;
        const Vec3 v(float(4 * std::cos(angle)), 0, float(4 * std::sin(angle)));
        const CharacterId id = w.walker({0, 0, 0});
        w.walk(id, v, 60);
        const WorldPos from = w.world.character(id).position;
        for (int i = 0; i < 600; ++i) {
            w.world.step();
            ASSERT_NEAR(w.world.character(id).position.y, 0.0, 1e-4);
        }
        EXPECT_NEAR(level_distance(w.world.character(id).position, from), 20.0, 1e-3) << direction;
        w.world.remove_character(id);
    }
}

TEST(Character, slides_along_walls_and_stops_in_corners) {
    Ground g;
    g.floor(10).box({3, -1, -8}, {4, 3, 8}, 4).box({-8, -1, 3}, {8, 3, 4}, 4);
    Walled w(g.finish());
    const CharacterId id = w.walker({0, 0, 0});
    w.walk(id, Vec3(2, 0, 1), 240);
    EXPECT_NEAR(w.world.character(id).position.x, 3 - 0.35, 1e-3);
    EXPECT_GT(w.world.character(id).position.z, 1.5);
    w.walk(id, Vec3(2, 0, 2), 480);
    EXPECT_NEAR(w.world.character(id).position.x, 3 - 0.35, 1e-3);
    EXPECT_NEAR(w.world.character(id).position.z, 3 - 0.35, 1e-3);
    // and gets out again
    w.walk(id, Vec3(-2, 0, -2), 240);
    EXPECT_LT(w.world.character(id).position.x, 0.0);
}

TEST(Character, does_not_tunnel_at_any_speed) {
    Ground g;
    g.floor(10);
    g.triangle({5, -5, -500}, {5, 50, 0}, {5, -5, 500});  // without thickness
    g.triangle({-5, -5, -500}, {-5, 50, 0}, {-5, -5, 500});
    Walled w(g.finish());
    for (double speed = 1.0; speed <= 1e6; speed *= 3.7) {
        const CharacterId id = *w.world.add_character({.position = {0.2, 0.0, 0.1}, .ground_accel_m_s2 = 1e9f});
        for (const float sign : {1.0f, -1.0f}) {
            const int ticks = speed < 20 ? 2000 : 200;
            w.walk(id, Vec3(sign * float(speed), 0, 0.01f), ticks);
            const CharacterState c = w.world.character(id);
            EXPECT_NEAR(c.position.x, double(sign) * (5 - 0.35), 1e-3) << speed;
            EXPECT_NEAR(c.position.y, 0.0, 1e-3) << speed;
        }
        w.world.remove_character(id);
    }
}

TEST(Character, gets_out_of_a_wedge_and_a_ravine) {
    // Two beams closer than it is wide, and a trench whose sides are both too steep.
    Ground beams;
    beams.floor(12, -20).box({-8, -0.3f, 0.3f}, {8, 0, 4}).box({-8, -0.3f, -4}, {8, 0, -0.3f});
    Ground trench;
    trench.triangle({-20, 0, 0}, {20, 0, 0}, {20, 8, 3}).triangle({-20, 0, 0}, {20, 8, 3}, {-20, 8, 3});
    trench.triangle({-20, 0, 0}, {20, 8, -3}, {20, 0, 0}).triangle({-20, 0, 0}, {-20, 8, -3}, {20, 8, -3});
    for (const Ground* ground : {&beams, &trench}) {
        Walled w(ground->finish());
        const CharacterId id = w.walker({0, 3, 0.02});
        w.walk(id, Vec3(0.0f), 600);
        const double rests = w.world.character(id).position.y;
        double highest = rests;
        ASSERT_TRUE(w.world.set_input(id, {.velocity_m_s = {3, 0, 0}, .jump = true}));
        for (int i = 0; i < 240; ++i) {
            w.world.step();
            highest = std::max(highest, w.world.character(id).position.y);
        }
        EXPECT_GT(highest, rests + 0.8);
        EXPECT_GT(w.world.character(id).position.x, 1.0);
    }
}

TEST(Character, falls_from_any_height_onto_a_single_triangle) {
    for (const double height : {1.0, 50.0, 1000.0, 20000.0}) {
        Walled w(Ground().triangle({-5, 0, -5}, {0, 0, 5}, {5, 0, -5}).finish());
        const CharacterId id = *w.world.add_character({.position = {0, height, 0}, .max_fall_m_s = 1e6f});
        for (int i = 0; i < 120 * 100 && !w.world.character(id).on_ground; ++i) w.world.step();
        EXPECT_TRUE(w.world.character(id).on_ground) << height;
        EXPECT_NEAR(w.world.character(id).position.y, 0.0, 1e-3) << height;
    }
}

TEST(Character, jumps_as_high_as_asked) {
    Walled w(Ground().floor(4).finish());
    const CharacterId id = w.walker({0, 0, 0});
    w.walk(id, Vec3(0.0f), 10);
    ASSERT_TRUE(w.world.set_input(id, {.jump = true}));
    w.world.step();
    ASSERT_TRUE(w.world.set_input(id, {}));
    double highest = 0;
    for (int i = 0; i < 240; ++i) {
        w.world.step();
        highest = std::max(highest, w.world.character(id).position.y);
    }
    EXPECT_NEAR(highest, 1.0, 0.01);
    EXPECT_TRUE(w.world.character(id).on_ground);
}

TEST(Character, crouches_under_and_stands_up_only_where_there_is_room) {
    Ground g;
    g.floor(10).box({1, 1.3f, -5}, {4, 3, 5});
    Walled w(g.finish());
    const CharacterId id = w.walker({0, 0, 0});
    w.walk(id, Vec3(2, 0, 0), 120);
    EXPECT_LT(w.world.character(id).position.x, 0.7);
    ASSERT_TRUE(w.world.set_input(id, {.velocity_m_s = {2, 0, 0}, .crouch = true}));
    for (int i = 0; i < 120; ++i) w.world.step();
    EXPECT_GT(w.world.character(id).position.x, 1.5);
    w.walk(id, Vec3(0.0f), 60);
    EXPECT_TRUE(w.world.character(id).crouching);
    w.walk(id, Vec3(2, 0, 0), 360);
    EXPECT_FALSE(w.world.character(id).crouching);
}

TEST(Character, is_the_same_a_thousand_kilometres_from_the_origin) {
    const WorldPos far(1e6, 300, -1e6);
    Walled here(Ground().floor(20).stairs(12, 0.18f, 0.3f).finish());
    Walled there(Ground().floor(20).stairs(12, 0.18f, 0.3f).finish(far));
    const CharacterId a = here.walker({-1, 0, 0.25}), b = there.walker(far + WorldPos(-1, 0, 0.25));
    for (int i = 0; i < 600; ++i) {
        const Vec3 v(float(1.5 * std::cos(i * 0.01)), 0, float(1.5 * std::sin(i * 0.013)));
        here.walk(a, v, 1);
        there.walk(b, v, 1);
        ASSERT_LT(glm::length(here.world.character(a).position + far - there.world.character(b).position), 1e-4) << i;
    }
    there.walk(b, Vec3(0.0f), 120);
    const WorldPos stands = there.world.character(b).position;
    there.walk(b, Vec3(0.0f), 7200);
    EXPECT_LT(glm::length(there.world.character(b).position - stands), 1e-6);
}

TEST(Character, never_gets_below_random_hills) {
    const double relief = 40.0;
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 0, 1e6)}) {
        Walled w(make_terrain({.size_m = 600, .spacing_m = 10, .relief_m = relief}, {.origin = origin}));
        for (std::uint32_t seed = 0; seed < 12; ++seed) {
            Random random(seed);
            const double x = random.in(-200, 200), z = random.in(-200, 200);
            const CharacterId id = w.walker(origin + WorldPos(x, terrain_height(x, z, relief) + 3.0, z));
            const float speed = float(std::pow(10.0, random.in(0, 3)));
            for (int i = 0; i < 400; ++i) {
                if (i % 50 == 0) {
                    const double angle = random.in(0, 2 * kPi);
                    ASSERT_TRUE(w.world.set_input(
                        id, {.velocity_m_s = {speed * float(std::cos(angle)), 0, speed * float(std::sin(angle))},
                             .jump = random.unit() < 0.3}));
                }
                w.world.step();
                const CharacterState c = w.world.character(id);
                const DVec3 p = c.position - origin;
                if (std::abs(p.x) > 290 || std::abs(p.z) > 290) break;  // walked off
                const auto below = w.world.cast_ray(c.position + DVec3(0, 0.5, 0), {0, -1, 0}, 1000.0);
                ASSERT_TRUE(below) << "seed " << seed << " tick " << i;
            }
            w.world.remove_character(id);
        }
    }
}

TEST(Character, walks_among_soup_without_getting_stuck_or_lost) {
    for (std::uint32_t seed = 0; seed < 30; ++seed) {
        Walled w(make_triangle_soup({.triangles = 400, .size_m = 12, .edge_m = 5}, {.seed = seed}));
        const CharacterId id = w.walker({0, 14, 0});
        Random random(seed);
        for (int i = 0; i < 600; ++i) {
            if (i % 40 == 0) {
                ASSERT_TRUE(w.world.set_input(id, {.velocity_m_s = random.in_box({-6, 0, -6}, {6, 0, 6}),
                                                   .jump = random.unit() < 0.5,
                                                   .crouch = random.unit() < 0.3}));
            }
            const CharacterState before = w.world.character(id);
            w.world.step();
            const CharacterState c = w.world.character(id);
            ASSERT_TRUE(std::isfinite(glm::length(c.position))) << seed;
            ASSERT_LT(glm::length(c.position - before.position), 1.5) << seed << " " << i;
        }
    }
}

TEST(Character, roams_the_town_above_its_ground_and_outside_of_its_walls) {
    Walled w(make_small_town());
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        Random random(seed);
        const double x = random.in(-60, 60), z = random.in(-200, 200);
        const CharacterId id = w.walker({x, small_town_ground(x, z) + 15.0, z});
        int still = 0;
        for (int i = 0; i < 1500; ++i) {
            if (i % 60 == 0) {
                ASSERT_TRUE(w.world.set_input(
                    id, {.velocity_m_s = random.in_box({-12, 0, -12}, {12, 0, 12}), .jump = random.unit() < 0.3}));
            }
            w.world.step();
            const CharacterState c = w.world.character(id);
            ASSERT_GT(c.position.y, small_town_ground(c.position.x, c.position.z) - 0.6) << seed << " " << i;
            // Nothing reaches into the capsule: a ball a hair thinner than it touches nothing.
            const auto within = w.world.cast_sphere(c.position + DVec3(0, 0.35, 0), 0.34f, {0, 1, 0}, 1.1);
            ASSERT_FALSE(within) << seed << " " << i << " at " << within->distance_m;
            still = !c.on_ground && glm::length(c.velocity_m_s) < 0.1f ? still + 1 : 0;
            ASSERT_LT(still, 60) << seed << " " << i;
        }
        w.world.remove_character(id);
    }
}

TEST(Character, masked_foliage_does_not_stop_it_and_trunks_do) {
    Walled w(make_forest({.trees = 60, .size_m = 60, .masked = true}));
    const CharacterId id = w.walker({-25, 0.5, 1.7});
    w.walk(id, Vec3(4, 0, 0), 12 * 120);
    EXPECT_GT(w.world.character(id).position.x, 10.0);
}

}  // namespace
}  // namespace ff::test
