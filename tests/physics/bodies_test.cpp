#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/physics/physics_worlds.h"

namespace ff::test {
namespace {

using physics::BodyDesc;
using physics::BodyId;
using physics::BodyState;
using physics::CharacterId;
using physics::Motion;
using physics::Shape;
using physics::StepStats;

BodyDesc at(const Shape& shape, const WorldPos& position) {
    return {.shape = shape, .pose = {.position = position}};
}
void run(Walled& w, int ticks) {
    for (int i = 0; i < ticks; ++i) w.world.step();
}

/// A body of each kind that falls onto a flat floor, and how high its origin lies then.
struct Resting {
    Shape shape;
    double height;
};
const Resting kResting[] = {
    {physics::box_shape({0.3f, 0.2f, 0.5f}), 0.2},
    {physics::sphere_shape(0.4f), 0.4},
    {physics::capsule_shape(0.25f, 0.5f), 0.75},
};

TEST(Bodies, fall_to_rest_and_sleep) {
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 500, -1e6)}) {
        for (const Resting& r : kResting) {
            Walled w(Ground().floor(6).finish(origin));
            BodyDesc desc = at(r.shape, origin + WorldPos(0.3, r.height + 0.5, 0.2));
            desc.angular_damping = 0.8f;
            const BodyId id = *w.world.add_body(desc);
            run(w, 10 * 120);
            const BodyState s = w.world.body(id);
            EXPECT_TRUE(s.asleep) << int(r.shape.kind);
            EXPECT_NEAR(s.pose.position.y - origin.y, r.height, 0.005) << int(r.shape.kind);
            EXPECT_LT(std::hypot(s.pose.position.x - origin.x - 0.3, s.pose.position.z - origin.z - 0.2), 0.05);
        }
    }
}

TEST(Bodies, fall_as_gravity_says) {
    Walled w(make_empty_world());
    BodyDesc desc = at(physics::sphere_shape(0.5f), {0, 0, 0});
    desc.linear_damping = 0.0f;
    const BodyId id = *w.world.add_body(desc);
    run(w, 240);
    // semi-implicit: half a tick's speed more than 1/2 g t^2
    EXPECT_NEAR(w.world.body(id).pose.position.y, -0.5 * 9.81 * 2.0 * (2.0 + 1.0 / 120.0), 1e-3);
}

TEST(Bodies, stacks_of_boxes_stand_and_sleep) {
    Walled w(Ground().floor(6).finish());
    std::vector<BodyId> stack;
    for (int i = 0; i < 6; ++i)
        stack.push_back(*w.world.add_body(at(physics::box_shape(Vec3(0.25f)), {0.1, 0.26 + 0.51 * i, 0.1})));
    run(w, 10 * 120);
    for (int i = 0; i < 6; ++i) {
        const BodyState s = w.world.body(stack[std::size_t(i)]);
        EXPECT_NEAR(s.pose.position.y, 0.25 + 0.5 * i, 0.02) << i;
        EXPECT_LT(std::hypot(s.pose.position.x - 0.1, s.pose.position.z - 0.1), 0.04) << i;
        EXPECT_TRUE(s.asleep) << i;
    }
}

TEST(Bodies, slide_down_a_slope_as_friction_says) {
    // tan 20 = 0.364: friction 0.6 holds, 0.1 does not.
    for (const float friction : {0.6f, 0.1f}) {
        Walled w(Ground().ramp(20, 60).finish());
        BodyDesc desc = at(physics::box_shape({0.4f, 0.2f, 0.4f}), {20, 20 * std::tan(radians_of(20.0)) + 0.25, 0});
        desc.pose.rotation = glm::angleAxis(float(radians_of(20.0)), Vec3(0, 0, 1));
        desc.friction = friction;
        desc.linear_damping = 0.0f;
        const BodyId id = *w.world.add_body(desc);
        run(w, 120);
        const double gone = glm::length(w.world.body(id).pose.position - desc.pose.position);
        if (friction > 0.5f) {
            EXPECT_LT(gone, 0.1);
        } else {
            const double a = 9.81 * (std::sin(radians_of(20.0)) - 0.1 * std::cos(radians_of(20.0)));
            EXPECT_NEAR(gone, 0.5 * a, 0.15);
        }
    }
}

TEST(Bodies, boxes_slide_over_inner_edges_without_a_bump) {
    Walled w(Ground().floor(30).finish());
    BodyDesc desc = at(physics::box_shape({0.3f, 0.2f, 0.25f}), {-20, 0.201, 0.13});
    desc.velocity_m_s = {8, 0, 3};
    desc.friction = 0.05f;
    const BodyId id = *w.world.add_body(desc);
    for (int i = 0; i < 240; ++i) {
        w.world.step();
        ASSERT_LT(w.world.body(id).pose.position.y, 0.22) << i;
    }
    EXPECT_GT(w.world.body(id).pose.position.x, -8.0);
}

TEST(Bodies, balls_roll_on_and_come_to_rest) {
    Walled w(Ground().floor(30).finish());
    BodyDesc desc = at(physics::sphere_shape(0.3f), {-20, 0.3, 0});
    desc.velocity_m_s = {3, 0, 0};
    desc.rolling_resistance = 0.05f;
    const BodyId id = *w.world.add_body(desc);
    run(w, 60);
    EXPECT_GT(glm::length(w.world.body(id).spin_rad_s), 4.0f);
    run(w, 20 * 120);
    EXPECT_TRUE(w.world.body(id).asleep);
    EXPECT_GT(w.world.body(id).pose.position.x, -18.0);
    EXPECT_LT(w.world.body(id).pose.position.x, 10.0);
}

TEST(Bodies, bounce_as_restitution_says) {
    Walled w(Ground().floor(6).finish());
    BodyDesc desc = at(physics::sphere_shape(0.3f), {0, 2.3, 0});
    desc.restitution = 0.5f;
    desc.linear_damping = 0.0f;
    const BodyId id = *w.world.add_body(desc);
    run(w, 77);  // 0.64 s of fall
    double highest = 0;
    for (int i = 0; i < 120; ++i) {
        w.world.step();
        highest = std::max(highest, w.world.body(id).pose.position.y);
    }
    EXPECT_NEAR(highest - 0.3, 0.5 * 0.5 * 2.0, 0.08);
}

TEST(Bodies, do_not_tunnel_at_any_speed) {
    for (double speed = 2.0; speed < 1e6; speed *= 4.3) {
        for (const Resting& r : kResting) {
            Walled w(Ground().triangle({5, -500, -500}, {5, 500, 0}, {5, -500, 500}).finish());
            BodyDesc desc = at(r.shape, {0.1, 0.2, 0.3});
            desc.velocity_m_s = {float(speed), 0, 0};
            desc.spin_rad_s = {3, 2, 1};
            const BodyId id = *w.world.add_body(desc);
            for (int i = 0; i < 300; ++i) {
                w.world.step();
                ASSERT_LT(w.world.body(id).pose.position.x, 5.0) << speed << " kind " << int(r.shape.kind);
            }
        }
    }
}

TEST(Bodies, hulls_of_a_mesh_rest_on_their_faces) {
    Ground g;
    g.floor(6);
    scene::SceneData data = g.finish();
    scene::MeshSource wedge;
    append_triangle(wedge, {0, 0, 0}, {0, 0, 1}, {1, 0, 1}, 0);
    append_triangle(wedge, {0, 0, 0}, {1, 0, 1}, {1, 0, 0}, 0);
    append_triangle(wedge, {0, 0, 0}, {0, 0.5f, 1}, {0, 0, 1}, 0);
    append_triangle(wedge, {0, 0.5f, 0}, {0, 0.5f, 1}, {1, 0, 1}, 0);
    const std::uint32_t mesh = data.add_mesh(scene::prepare_mesh(wedge, data.materials));
    data.add_instance(mesh, {0, -50, 0}, Mat3(1.0f), 1);
    data.finish(64);
    Walled w(std::move(data));
    const std::uint32_t id_of_wedge = w.view.meshes[0].triangle_count == 4 ? 0 : 1;
    const BodyId id = *w.world.add_body(at(physics::hull_shape(id_of_wedge), {0, 0.3, 0}));
    run(w, 600);
    EXPECT_NEAR(w.world.body(id).pose.position.y, 0.0, 0.01);
    EXPECT_TRUE(w.world.body(id).asleep);
}

TEST(Bodies, on_random_hills_stay_above_them) {
    const double relief = 30.0;
    Walled w(make_terrain({.size_m = 400, .spacing_m = 8, .relief_m = relief}));
    std::vector<BodyId> all;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        Random random(seed);
        const double x = random.in(-120, 120), z = random.in(-120, 120);
        BodyDesc desc = at(kResting[seed % 3].shape, {x, terrain_height(x, z, relief) + 3, z});
        desc.velocity_m_s = random.in_box(Vec3(-20), Vec3(20));
        desc.spin_rad_s = random.in_box(Vec3(-5), Vec3(5));
        all.push_back(*w.world.add_body(desc));
    }
    for (int i = 0; i < 900; ++i) w.world.step();
    for (const BodyId id : all) {
        const WorldPos p = w.world.body(id).pose.position;
        if (std::abs(p.x) > 190 || std::abs(p.z) > 190) continue;
        const auto ground = w.world.cast_ray(p, {0, -1, 0}, 100, {.bodies = false});
        ASSERT_TRUE(ground) << id.index;
    }
}

TEST(Bodies, a_kinematic_platform_carries_what_stands_on_it) {
    Walled w(Ground().floor(2, -5).finish());
    BodyDesc deck = at(physics::box_shape({2, 0.1f, 2}), {0, 0, 0});
    deck.motion = Motion::kinematic;
    const BodyId ferry = *w.world.add_body(deck);
    const BodyId crate = *w.world.add_body(at(physics::box_shape(Vec3(0.3f)), {1, 0.45, 1}));
    const CharacterId id = w.walker({-0.5, 0.15, 0});
    run(w, 60);
    const WorldPos start = w.world.character(id).position;
    for (int i = 1; i <= 600; ++i) {
        const float turn = 0.1f * float(i) / 120.0f;
        ASSERT_TRUE(w.world.move_kinematic(
            ferry, {{0.02 * i, 0.4 * std::sin(i * 0.02), 0}, glm::angleAxis(turn, Vec3(0, 1, 0))}));
        w.world.step();
    }
    const auto rider = w.world.character(id);
    EXPECT_TRUE(rider.on_ground);
    EXPECT_EQ(rider.ground, ferry);
    EXPECT_NEAR(rider.position.x - start.x, 12.0, 0.2);
    EXPECT_NEAR(w.world.body(crate).pose.position.x, 12.0 + 1.0, 0.7);
}

TEST(Bodies, doors_push_characters_and_never_through_walls) {
    Ground g;
    g.floor(6).box({-6, 0, 1.0f}, {6, 3, 1.2f}, 4);
    Walled w(g.finish());
    BodyDesc panel = at(physics::box_shape({0.5f, 1.0f, 0.05f}), {0, 1, -1.0});
    panel.motion = Motion::kinematic;
    const BodyId door = *w.world.add_body(panel);
    const CharacterId id = w.walker({0, 0, 0.2});
    for (int i = 0; i < 400; ++i) {
        ASSERT_TRUE(w.world.move_kinematic(door, {{0, 1, std::min(-1.0 + 0.01 * i, 0.9)}, {1, 0, 0, 0}}));
        w.world.step();
        ASSERT_LT(w.world.character(id).position.z, 1.0);
    }
}

TEST(Bodies, a_mesh_moves_as_it_is_with_its_hollows) {
    // An arch: two posts and a lintel. What fits goes through it, and it carries what lies on it.
    scene::MeshSource arch;
    append_box(arch, {-1.5f, 0, -0.2f}, {-0.8f, 2.2f, 0.2f}, 1, 0);
    append_box(arch, {0.8f, 0, -0.2f}, {1.5f, 2.2f, 0.2f}, 1, 0);
    append_box(arch, {-1.5f, 2.2f, -0.2f}, {1.5f, 2.5f, 0.2f}, 1, 0);
    Ground g;
    g.floor(8);
    scene::SceneData data = g.finish();
    const std::size_t before = data.meshes.size();
    data.add_mesh(scene::prepare_mesh(arch, data.materials));
    Walled w(std::move(data));
    BodyDesc desc = at(physics::mesh_shape(std::uint32_t(before)), {0, 0, 0});
    desc.motion = Motion::kinematic;
    const BodyId gate = *w.world.add_body(desc);
    const BodyId pot = *w.world.add_body(at(physics::box_shape(Vec3(0.1f)), {0, 2.65, 0}));
    const CharacterId through = w.walker({0, 0, -3}), against = w.walker({1.1, 0, -3});
    for (const CharacterId id : {through, against}) ASSERT_TRUE(w.world.set_input(id, {.velocity_m_s = {0, 0, 2}}));
    run(w, 360);
    EXPECT_GT(w.world.character(through).position.z, 2.0);
    EXPECT_LT(w.world.character(against).position.z, -0.5);
    EXPECT_NEAR(w.world.body(pot).pose.position.y, 2.6, 0.01);
    for (int i = 1; i <= 240; ++i) {
        ASSERT_TRUE(w.world.move_kinematic(gate, {{0.005 * i, 0, 0}, {1, 0, 0, 0}}));
        w.world.step();
    }
    EXPECT_NEAR(w.world.body(pot).pose.position.x, 1.2, 0.15);
    const auto hit = w.world.cast_ray({1.2, 1, -5}, {0, 0, 1}, 20);
    EXPECT_FALSE(hit);
    EXPECT_EQ(w.world.cast_ray({0, 1, -5}, {0, 0, 1}, 20)->body, gate);
}

TEST(Bodies, a_cart_pushes_who_stands_in_its_way) {
    for (const double speed : {1.0, 5.0, 15.0, 30.0}) {
        Walled w(Ground().floor(40).finish());
        BodyDesc desc = at(physics::box_shape({1, 0.8f, 0.6f}), {-4, 0.85, 0});
        desc.motion = Motion::kinematic;
        const BodyId cart = *w.world.add_body(desc);
        const CharacterId id = w.walker({0, 0, 0.05});
        run(w, 10);
        for (int i = 1; i <= int(8.0 / speed * 120); ++i) {
            ASSERT_TRUE(w.world.move_kinematic(cart, {{-4 + speed / 120 * i, 0.85, 0}, {1, 0, 0, 0}}));
            w.world.step();
            const DVec3 d = w.world.character(id).position - w.world.body(cart).pose.position;
            ASSERT_TRUE(std::abs(d.x) > 1.3 || std::abs(d.z) > 0.9 || d.y > 0.5) << speed << " " << i;
        }
        EXPECT_GT(w.world.character(id).position.x, 1.0) << speed;
    }
}

TEST(Bodies, characters_push_light_bodies_and_not_heavy_ones) {
    for (const float mass : {5.0f, 5000.0f}) {
        Walled w(Ground().floor(20).finish());
        BodyDesc desc = at(physics::box_shape(Vec3(0.4f)), {2, 0.4, 0});
        desc.mass_kg = mass;
        const BodyId crate = *w.world.add_body(desc);
        run(w, 120);
        const CharacterId id = w.walker({0, 0, 0});
        w.walk(id, Vec3(3, 0, 0), 360);
        const double moved = w.world.body(crate).pose.position.x - 2.0;
        if (mass < 10) {
            EXPECT_GT(moved, 2.0);
        } else {
            EXPECT_LT(moved, 0.05);
            EXPECT_LT(w.world.character(id).position.x, 1.3);
        }
    }
}

TEST(Bodies, characters_stand_on_dynamic_bodies) {
    Walled w(Ground().floor(10).finish());
    const BodyId crate = *w.world.add_body(at(physics::box_shape(Vec3(0.5f)), {0, 0.5, 0}));
    run(w, 120);
    const CharacterId id = w.walker({0.1, 1.5, 0.1});
    run(w, 600);
    EXPECT_TRUE(w.world.character(id).on_ground);
    EXPECT_NEAR(w.world.character(id).position.y, 1.0, 0.02);
    EXPECT_EQ(w.world.character(id).ground, crate);
}

TEST(Bodies, far_from_every_character_are_held_where_they_are) {
    physics::PhysicsSettings settings;
    settings.active_range_m = 50.0;
    Walled w(Ground().floor(4).finish(), settings);
    w.walker({0, 0, 0});
    const BodyId near = *w.world.add_body(at(physics::sphere_shape(0.3f), {2, 3, 0}));
    const BodyId far = *w.world.add_body(at(physics::sphere_shape(0.3f), {200, 3, 0}));
    const StepStats stats = w.world.step();
    EXPECT_EQ(stats.bodies_stepped, 1u);
    EXPECT_EQ(stats.bodies_held, 1u);
    run(w, 30);
    EXPECT_LT(w.world.body(near).pose.position.y, 2.9);
    EXPECT_EQ(w.world.body(far).pose.position.y, 3.0);
}

TEST(Bodies, sleeping_ones_are_not_stepped_until_touched) {
    Walled w(Ground().floor(60).finish());
    std::vector<BodyId> all;
    for (int i = 0; i < 10000; ++i) {
        BodyDesc desc = at(physics::box_shape(Vec3(0.2f)), {-50 + (i % 100), 0.2, -50 + (i / 100)});
        desc.asleep = true;
        all.push_back(*w.world.add_body(desc));
    }
    StepStats stats = w.world.step();
    EXPECT_EQ(stats.bodies_stepped, 0u);
    EXPECT_EQ(stats.bodies_asleep, 10000u);
    EXPECT_EQ(stats.triangles_tested, 0u);
    // One that falls onto another wakes that one, and not the rest.
    const BodyId ball = *w.world.add_body(at(physics::sphere_shape(0.2f), {0, 2, 0}));
    std::uint32_t most = 0;
    for (int i = 0; i < 240; ++i) most = std::max(most, w.world.step().bodies_stepped);
    EXPECT_GE(most, 2u);
    EXPECT_LT(most, 10u);
    EXPECT_TRUE(w.world.is_alive(ball));
    // What it lay on is gone: it falls.
    run(w, 1200);
    EXPECT_EQ(w.world.step().bodies_stepped, 0u);
}

TEST(Bodies, wake_when_their_support_is_taken) {
    Walled w(Ground().floor(6).finish());
    BodyDesc table = at(physics::box_shape({1, 0.5f, 1}), {0, 0.5, 0});
    table.motion = Motion::kinematic;
    const BodyId support = *w.world.add_body(table);
    const BodyId cup = *w.world.add_body(at(physics::box_shape(Vec3(0.1f)), {0, 1.1, 0}));
    run(w, 300);
    ASSERT_TRUE(w.world.body(cup).asleep);
    ASSERT_TRUE(w.world.remove_body(support));
    run(w, 240);
    EXPECT_NEAR(w.world.body(cup).pose.position.y, 0.1, 0.01);
}

}  // namespace
}  // namespace ff::test
