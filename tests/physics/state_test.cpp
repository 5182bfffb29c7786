#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/core/jobs.h"
#include "tests/physics/physics_worlds.h"

namespace ff::test {
namespace {

using physics::BodyDesc;
using physics::BodyId;
using physics::CharacterId;
using physics::Motion;

/// A busy place: hills, piles, a lift, characters that run and jump among them, bodies that come and go.
class Busy {
  public:
    explicit Busy(std::uint32_t seed = 1, const WorldPos& origin = WorldPos(0.0))
        : origin_(origin),
          walled_(make_terrain({.size_m = 300, .spacing_m = 6, .relief_m = 12}, {.seed = 3, .origin = origin})),
          seed_(seed) {}
    physics::PhysicsWorld& world() { return walled_.world; }

    void populate() {
        Random random(seed_);
        for (int i = 0; i < 40; ++i) {
            BodyDesc desc;
            const Vec3 size = random.in_box(Vec3(0.2f), Vec3(0.6f));
            if (i % 3 == 0) desc.shape = physics::box_shape(size);
            if (i % 3 == 1) desc.shape = physics::sphere_shape(size.x);
            if (i % 3 == 2) desc.shape = physics::capsule_shape(size.x, size.y);
            const double x = random.in(-5, 5), z = random.in(-5, 5);
            desc.pose.position = origin_ + WorldPos(x, terrain_height(x, z, 12) + 1.0 + 0.3 * i, z);
            desc.spin_rad_s = random.in_box(Vec3(-4), Vec3(4));
            desc.restitution = i % 5 == 0 ? 0.4f : 0.0f;
            bodies_.push_back(*world().add_body(desc));
        }
        BodyDesc lift;
        lift.shape = physics::box_shape({2, 0.2f, 2});
        lift.motion = Motion::kinematic;
        lift.pose.position = origin_ + WorldPos(0, terrain_height(0, 0, 12), 0);
        bodies_.push_back(*world().add_body(lift));
        for (int i = 0; i < 3; ++i)
            (void)*world().add_character({.position = origin_ + WorldPos(3.0 * i - 3, 12.0 + i, 4)});
    }

    /// A function of the tick alone, as the game's would be.
    void play_tick() {
        const std::uint64_t tick = world().tick();
        const double t = double(tick) / 120.0;
        for (std::uint32_t i = 0; i < 3; ++i)
            EXPECT_TRUE(world().set_input(
                {i, 1}, {.velocity_m_s = {float(4 * std::cos(t + i)), 0, float(4 * std::sin(1.3 * t + i))},
                         .jump = (tick / 90 + i) % 3 == 0,
                         .crouch = (tick / 200 + i) % 5 == 0}));
        EXPECT_TRUE(world().move_kinematic(
            {40, 1}, {origin_ + WorldPos(0, terrain_height(0, 0, 12) + 1.5 * std::sin(t), 0), {1, 0, 0, 0}}));
        if (tick % 97 == 50) {
            BodyDesc desc;
            desc.shape = physics::box_shape(Vec3(0.3f));
            desc.pose.position = origin_ + WorldPos(std::sin(t), 14, std::cos(t));
            EXPECT_TRUE(world().add_body(desc));
        }
        if (tick % 131 == 100) world().remove_body({std::uint32_t(tick / 131) % 40, 1});
        world().step();
    }

  private:
    WorldPos origin_;
    Walled walled_;
    std::uint32_t seed_;
    std::vector<BodyId> bodies_;
};

TEST(State, is_the_same_for_any_number_of_workers_and_every_run) {
    std::vector<std::uint64_t> first;
    for (const int workers : {1, 2, 3}) {
        const WorkerLimit limit(workers);
        Busy busy;
        busy.populate();
        std::vector<std::uint64_t> hashes;
        for (int i = 0; i < 500; ++i) {
            busy.play_tick();
            hashes.push_back(busy.world().hash());
        }
        if (first.empty()) first = hashes;
        const auto differs = std::mismatch(first.begin(), first.end(), hashes.begin()).first;
        EXPECT_EQ(differs - first.begin(), 500) << workers << " workers";
    }
}

// With and without optimisation, with and without sanitizers. The number changes whenever what is simulated does: then
// it is written anew, from a release build.
TEST(State, hash_is_that_of_every_build) {
    Ground g;
    g.floor(12).stairs(8, 0.2f, 0.4f).box({-6, 0, -6}, {-4, 1.5f, -4}, 2).box({-8, -1, 8}, {8, 2, 9}, 3);
    Walled w(g.finish());
    Random random(7);
    for (int i = 0; i < 30; ++i) {
        BodyDesc desc;
        const Vec3 size = random.in_box(Vec3(0.2f), Vec3(0.6f));
        if (i % 3 == 0) desc.shape = physics::box_shape(size);
        if (i % 3 == 1) desc.shape = physics::sphere_shape(size.x);
        if (i % 3 == 2) desc.shape = physics::capsule_shape(size.x, size.y);
        desc.pose.position = WorldPos(random.in_box({-3, 1, -3}, {3, 9, 3}));
        desc.velocity_m_s = random.in_box(Vec3(-5), Vec3(5));
        ASSERT_TRUE(w.world.add_body(desc));
    }
    const CharacterId walker = w.walker({-2, 0, 2});
    for (int i = 0; i < 600; ++i) {
        if (i % 30 == 0) {
            ASSERT_TRUE(w.world.set_input(
                walker, {.velocity_m_s = random.in_box({-5, 0, -5}, {5, 0, 5}), .jump = random.unit() < 0.3}));
        }
        w.world.step();
    }
    EXPECT_EQ(w.world.hash(), 17196489224628656399ull);
}

TEST(State, saved_and_continued_is_the_same_as_continued) {
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 0, 2e6)}) {
        Busy one(5, origin);
        one.populate();
        for (int i = 0; i < 600; ++i) {
            if (i % 60 == 30) {
                const std::vector<std::byte> state = one.world().state();
                Busy other(5, origin);
                ASSERT_TRUE(other.world().set_state(state));
                EXPECT_EQ(other.world().state(), state);
                // Here and there: both go on for a while, then this one is put back.
                std::vector<std::uint64_t> hashes;
                for (int k = 0; k < 60; ++k) {
                    one.play_tick();
                    hashes.push_back(one.world().hash());
                }
                for (int k = 0; k < 60; ++k) {
                    other.play_tick();
                    ASSERT_EQ(other.world().hash(), hashes[std::size_t(k)]) << "saved at " << i << ", tick " << k;
                }
                ASSERT_TRUE(one.world().set_state(state));
            }
            one.play_tick();
        }
    }
}

TEST(State, damaged_ones_are_refused_and_change_nothing) {
    Busy busy;
    busy.populate();
    for (int i = 0; i < 50; ++i) busy.play_tick();
    const std::vector<std::byte> good = busy.world().state();
    const std::uint64_t hash = busy.world().hash();
    for (std::size_t cut = 0; cut < good.size(); cut += cut < 64 ? 1 : 37) {
        EXPECT_FALSE(busy.world().set_state(std::span(good).first(cut))) << cut;
        ASSERT_EQ(busy.world().hash(), hash);
    }
    std::vector<std::byte> longer = good;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(busy.world().set_state(longer));
    // Any byte: refused, or a state that can be stepped.
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        Random random(seed);
        std::vector<std::byte> spoiled = good;
        spoiled[random.below(std::uint32_t(spoiled.size()))] ^= std::byte(1u << random.below(8));
        if (!busy.world().set_state(spoiled)) continue;
        busy.world().step();
        ASSERT_TRUE(busy.world().set_state(good));
    }
    physics::PhysicsSettings other;
    other.gravity_m_s2 = {0, -3, 0};
    Walled elsewhere(make_empty_world(), other);
    EXPECT_FALSE(elsewhere.world.set_state(good));
}

TEST(State, numbers_that_are_none_are_refused) {
    Walled w(Ground().floor(4).finish());
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const BodyId body = *w.world.add_body({});
    const CharacterId walker = w.walker({0, 0, 0});
    const std::uint64_t hash = w.world.hash();
    for (const float bad : {nan, inf, -inf, 1e30f}) {
        EXPECT_FALSE(w.world.set_input(walker, {.velocity_m_s = {bad, 0, 0}}));
        EXPECT_FALSE(w.world.set_position(walker, {0, double(bad), 0}));
        EXPECT_FALSE(w.world.add_character({.position = {double(bad), 0, 0}}));
        EXPECT_FALSE(w.world.add_character({.radius_m = bad}));
        EXPECT_FALSE(w.world.add_body({.shape = physics::box_shape({1, bad, 1})}));
        EXPECT_FALSE(w.world.add_body({.shape = physics::sphere_shape(bad)}));
        EXPECT_FALSE(w.world.add_body({.pose = {.position = {0, double(bad), 0}}}));
        EXPECT_FALSE(w.world.add_body({.pose = {.rotation = {bad, 0, 0, 0}}}));
        EXPECT_FALSE(w.world.add_body({.mass_kg = bad}));
        EXPECT_FALSE(w.world.set_pose(body, {.position = {double(bad), 0, 0}}));
        EXPECT_FALSE(w.world.set_velocity(body, Vec3(bad), Vec3(0)));
        EXPECT_FALSE(w.world.apply_impulse(body, Vec3(bad), {0, 0, 0}));
        EXPECT_FALSE(w.world.cast_ray({0, double(bad), 0}, {0, -1, 0}, 10));
    }
    EXPECT_FALSE(w.world.cast_ray({0, 1, 0}, {0, nan, 0}, 10));
    EXPECT_FALSE(w.world.cast_ray({0, 1, 0}, {0, 0, 0}, 10));
    EXPECT_FALSE(w.world.cast_ray({0, 1, 0}, {0, -1, 0}, double(nan)));
    EXPECT_FALSE(w.world.add_body({.shape = physics::hull_shape(99)}));
    EXPECT_FALSE(w.world.add_body({.shape = physics::hull_shape(0)}));  // a floor has no volume
    EXPECT_FALSE(w.world.add_body({.shape = physics::mesh_shape(0)}));  // dynamic
    EXPECT_FALSE(w.world.move_kinematic(body, {}));
    EXPECT_EQ(w.world.hash(), hash);
    EXPECT_TRUE(w.world.remove_body(body));
    EXPECT_FALSE(w.world.remove_body(body));
    EXPECT_FALSE(w.world.set_velocity(body, Vec3(0), Vec3(0)));
}

}  // namespace
}  // namespace ff::test
