#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "engine/ecs/transform_hierarchy.h"
#include "engine/physics/capsule.h"
#include "engine/physics/obstacles.h"
#include "engine/physics/systems.h"
#include "tests/physics/physics_worlds.h"

namespace ff::test {
namespace {

using physics::BodyId;
using physics::Nearest;
using physics::Segment;
using physics::Triangle;

DVec3 point(Random& random, double size) {
    return {random.in(-size, size), random.in(-size, size), random.in(-size, size)};
}

TEST(Capsule, nearest_points_are_the_nearest_of_many_samples) {
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        Random random(seed);
        const Segment s{point(random, 3), point(random, 3)};
        Triangle t{point(random, 3), point(random, 3), point(random, 3)};
        if (seed % 7 == 0) t.c = t.a + (t.b - t.a) * 0.3;  // no area
        if (seed % 11 == 0) t.b = t.a;
        const Nearest n = physics::nearest(s, t);
        EXPECT_NEAR(glm::length(n.on_segment - n.on_other), n.distance, 1e-12);
        double sampled = 1e9;
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; j <= 40; ++j)
                for (int k = 0; j + k <= 40; ++k) {
                    const DVec3 p = glm::mix(s.a, s.b, i / 40.0);
                    const DVec3 q = t.a + (t.b - t.a) * (j / 40.0) + (t.c - t.a) * (k / 40.0);
                    sampled = std::min(sampled, glm::length(p - q));
                }
        EXPECT_LE(n.distance, sampled + 1e-12) << seed;
        EXPECT_GE(n.distance, sampled - 0.3) << seed;
    }
}

TEST(Capsule, a_sweep_stops_at_the_first_touch) {
    int touched = 0;
    for (std::uint32_t seed = 0; seed < 4000; ++seed) {
        Random random(seed);
        const DVec3 foot = point(random, 4);
        const Segment s{foot, foot + DVec3(0, random.in(0, 2), 0)};
        const Triangle t{point(random, 2), point(random, 2), point(random, 2)};
        const double radius = random.in(0.05, 0.5);
        const DVec3 along = point(random, 8) * std::pow(10.0, random.in(-2, 3));
        if (physics::nearest(s, t).distance <= radius) continue;
        const auto hit = physics::touch(s, radius, along, t, 1.0);
        const auto gap = [&](double time) {
            return physics::nearest({s.a + along * time, s.b + along * time}, t).distance - radius;
        };
        if (hit) {
            ++touched;
            EXPECT_LT(gap(hit->time), 1e-5 + 1e-7 * glm::length(along)) << seed;
        }
        const double end = hit ? hit->time : 1.0;
        for (int i = 0; i < 200; ++i) EXPECT_GT(gap(end * i / 200.0), -1e-6) << seed;
    }
    EXPECT_GT(touched, 100);
}

TEST(Queries, rays_meet_what_the_plain_search_meets) {
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        Walled w(make_triangle_soup({.triangles = 300}, {.seed = seed, .origin = {1000, 0, -2000}}));
        Random random(seed);
        for (int i = 0; i < 200; ++i) {
            const WorldPos from = WorldPos(1000, 0, -2000) + point(random, 20);
            const Vec3 direction(point(random, 1));
            // Every triangle, one after the other.
            double nearest = 1e9;
            for (const scene::Instance& instance : w.view.instances) {
                const scene::Mesh& mesh = w.view.meshes[instance.mesh];
                for (std::uint32_t k = 0; k < mesh.triangle_count; ++k) {
                    DVec3 p[3];
                    for (std::uint32_t c = 0; c < 3; ++c) {
                        const std::uint32_t v = w.view.indices[3 * (mesh.first_triangle + k) + c];
                        p[c] = instance.position +
                               DMat3(instance.world_from_mesh) * DVec3(w.view.positions[mesh.first_vertex + v]);
                    }
                    const DVec3 d(direction), ab = p[1] - p[0], ac = p[2] - p[0], q = glm::cross(d, ac);
                    const double det = glm::dot(ab, q);
                    if (det == 0.0) continue;
                    const DVec3 to = from - p[0], r = glm::cross(to, ab);
                    const double u = glm::dot(to, q) / det, v = glm::dot(d, r) / det, t = glm::dot(ac, r) / det;
                    if (u >= 0 && v >= 0 && u + v <= 1 && t >= 0) nearest = std::min(nearest, t * glm::length(d));
                }
            }
            const auto hit = w.world.cast_ray(from, direction, 1e6);
            ASSERT_EQ(bool(hit), nearest < 1e8) << seed << " " << i;
            if (hit) {
                EXPECT_NEAR(hit->distance_m, nearest, 1e-6);
            }
        }
    }
}

/// The plain search that the walk of the hierarchies stands beside: every triangle, in the order of the arrays.
std::optional<physics::Touch> first_touch(const scene::StaticScene& scene, const Segment& capsule, double radius,
                                          const DVec3& along) {
    std::optional<physics::Touch> first;
    for (const scene::Instance& instance : scene.instances) {
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        const DMat3 turn(instance.world_from_mesh);
        const auto corner = [&](std::uint32_t k) {
            const std::uint32_t v = mesh.first_vertex + scene.indices[3 * mesh.first_triangle + k];
            return instance.position + turn * DVec3(scene.positions[v]);
        };
        for (std::uint32_t k = 0; k < 3 * mesh.triangle_count; k += 3)
            if (const auto hit = physics::touch(capsule, radius, along, {corner(k), corner(k + 1), corner(k + 2)}, 1.0);
                hit && (!first || hit->time < first->time))
                first = hit;
    }
    return first;
}

TEST(Queries, sweeps_stop_where_the_plain_search_stops) {
    int hits = 0;
    for (std::uint32_t seed = 0; seed < 24; ++seed) {
        const WorldPos origin = seed % 2 == 0 ? WorldPos(0.0) : WorldPos(1e6, -300, 2e6);
        Walled w(seed % 3 == 0
                     ? make_forest({.trees = 20, .size_m = 20, .masked = false}, {.seed = seed, .origin = origin})
                     : make_triangle_soup({.triangles = 200}, {.seed = seed, .origin = origin}));
        const physics::BodyStore none(w.view);
        std::vector<std::uint32_t> slots;
        physics::ObstacleQuery query(w.view, none, slots);
        Random random(seed);
        for (int i = 0; i < 60; ++i) {
            const DVec3 foot = origin + point(random, 14);
            const Segment capsule{foot, foot + DVec3(0, random.in(0, 1.5), 0)};
            const double radius = random.in(0.02, 0.6);
            const DVec3 along = point(random, 1) * std::pow(10.0, random.in(-1, 4));
            const auto fast = query.sweep(capsule, radius, along, {});
            const auto plain = first_touch(w.view, capsule, radius, along);
            ASSERT_EQ(bool(fast), bool(plain)) << seed << " " << i;
            if (!fast) continue;
            ++hits;
            EXPECT_EQ(fast->time, plain->time) << seed << " " << i;
        }
    }
    EXPECT_GT(hits, 300);
}

TEST(Queries, see_kilometres_and_around_bodies) {
    const double relief = 80.0;
    Walled w(make_terrain({.size_m = 8000, .spacing_m = 40, .relief_m = relief}));
    Random random(1);
    int seen = 0, hidden = 0;
    for (int i = 0; i < 300; ++i) {
        const double x0 = random.in(-3500, 3500), z0 = random.in(-3500, 3500);
        const double x1 = random.in(-3500, 3500), z1 = random.in(-3500, 3500);
        const WorldPos a(x0, terrain_height(x0, z0, relief) + 30, z0), b(x1, terrain_height(x1, z1, relief) + 30, z1);
        const bool sees = w.world.can_see(a, b);
        EXPECT_EQ(sees, w.world.can_see(b, a));
        ++(sees ? seen : hidden);
    }
    EXPECT_GT(seen, 20);
    EXPECT_GT(hidden, 20);

    const WorldPos high(0, 1000, 0), far(0, 1000, 5000);
    EXPECT_TRUE(w.world.can_see(high, far));
    physics::BodyDesc balloon{.shape = physics::sphere_shape(3.0f)};
    balloon.motion = physics::Motion::kinematic;
    balloon.pose.position = {0, 1001, 2500};
    const BodyId id = *w.world.add_body(balloon);
    EXPECT_FALSE(w.world.can_see(high, far));
    EXPECT_TRUE(w.world.can_see(high, far, {.except = id}));
    const auto hit = w.world.cast_ray(high, {0, 0, 1}, 1e5);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->body, id);
    EXPECT_NEAR(hit->distance_m, 2500 - std::sqrt(8.0), 1e-3);
    std::vector<BodyId> near;
    w.world.bodies_near({0, 1000, 2499}, 1.0f, near);
    EXPECT_EQ(near, std::vector<BodyId>{id});
    near.clear();
    w.world.bodies_near({0, 1000, 2400}, 1.0f, near);
    EXPECT_TRUE(near.empty());
}

TEST(Queries, spheres_stop_their_radius_before) {
    Walled w(Ground().floor(5).finish());
    const auto hit = w.world.cast_sphere({0.3, 4, 0.2}, 0.5f, {0, -2, 0}, 100);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance_m, 3.5, 1e-5);
    EXPECT_NEAR(hit->normal.y, 1.0, 1e-6);
    EXPECT_FALSE(w.world.cast_sphere({0.3, 4, 0.2}, 0.5f, {0, -2, 0}, 3.4));
    EXPECT_FALSE(w.world.cast_sphere({20, 4, 0.2}, 0.5f, {0, -2, 0}, 100));
    EXPECT_EQ(w.world.cast_sphere({0, 0.2, 0}, 0.5f, {0, 1, 0}, 100)->distance_m, 0.0);
}

TEST(Systems, move_entities_with_bodies_and_bodies_with_entities) {
    Walled w(Ground().floor(8).finish());
    ecs::Registry registry;
    ecs::Schedule schedule;
    physics::add_physics_system(schedule);
    schedule.run(registry);  // without a world: nothing
    registry.resource<physics::PhysicsTick>().world = &w.world;

    const ecs::Entity crate = registry.create(ecs::LocalTransform{.position = {0, 2, 0}});
    ASSERT_TRUE(attach_body(registry, w.world, crate, {.shape = physics::box_shape(Vec3(0.25f))}));
    const ecs::Entity door = registry.create(ecs::LocalTransform{.position = {3, 1, 0}});
    physics::BodyDesc desc{.shape = physics::box_shape({0.5f, 1.0f, 0.1f})};
    desc.motion = physics::Motion::kinematic;
    const BodyId door_body = *attach_body(registry, w.world, door, desc);
    const ecs::Entity player = registry.create(ecs::LocalTransform{.position = {-3, 0, 0}});
    registry.add<physics::Walker>(player, {*w.world.add_character({.position = {-3, 0, 0}}), {}});
    registry.get<physics::Walker>(player)->input.velocity_m_s = {0, 0, 2};

    for (int i = 0; i < 240; ++i) {
        registry.get<ecs::LocalTransform>(door)->position.x = 3.0 + 0.001 * i;
        schedule.run(registry);
    }
    EXPECT_NEAR(registry.get<ecs::LocalTransform>(crate)->position.y, 0.25, 0.01);
    EXPECT_NEAR(w.world.body(door_body).pose.position.x, 3.239, 1e-6);
    EXPECT_GT(registry.get<ecs::LocalTransform>(player)->position.z, 3.5);
    EXPECT_EQ(w.world.tick(), 240u);

    EXPECT_FALSE(attach_body(registry, w.world, registry.create(), {}));
    EXPECT_TRUE(detach(registry, w.world, crate));
    EXPECT_FALSE(detach(registry, w.world, crate));
    EXPECT_TRUE(detach(registry, w.world, player));
    schedule.run(registry);
}

}  // namespace
}  // namespace ff::test
