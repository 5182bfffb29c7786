#include "engine/scenery/scenery.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "engine/core/jobs.h"
#include "engine/scenery/birds.h"
#include "engine/scenery/loose_bodies.h"
#include "tests/support/worlds.h"

namespace ff::scenery {
namespace {

using effects::EffectId;

constexpr int kTicks = int(kTicksPerSecond);

/// A level floor, and a box of 1 m that may move. `birds` over the origin; bodies in a pile 20 m to the east.
std::unique_ptr<scene::World> make_world(std::uint32_t birds, int bodies) {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    scene::MeshSource floor, box;
    test::append_box(floor, Vec3(-200.0f, -1.0f, -200.0f), Vec3(200.0f, 0.0f, 200.0f), 1, 0);
    test::append_box(box, Vec3(-0.5f), Vec3(0.5f), 1, 0);
    const std::uint32_t floor_mesh = data.add_mesh(scene::prepare_mesh(floor, data.materials));
    const std::uint32_t box_mesh = data.add_mesh(scene::prepare_mesh(box, data.materials));
    data.add_instance(floor_mesh, WorldPos(0.0), Mat3(1.0f), 0);
    data.finish(64);
    scene::WorldInfo info;
    info.name = "yard";
    const auto model_at = [&](const WorldPos& position) {
        info.dynamic_instances.push_back({.mesh = box_mesh, .position = position});
        return scene::MovingModel{.position = position,
                                  .first_instance = std::uint32_t(info.dynamic_instances.size() - 1),
                                  .instance_count = 1};
    };
    if (birds > 0) info.flocks.push_back({model_at({0.0, 40.0, 0.0}), birds, 30.0f});
    for (int i = 0; i < bodies; ++i)
        info.loose_bodies.push_back({model_at({20.0 + 0.1 * i, 1.0 + 1.2 * i, 0.0}), 20.0f});
    return std::make_unique<scene::World>(std::move(data), std::move(info));
}

Camera looking_from(const WorldPos& position, double fov = radians_of(60.0)) {
    return {.position = position, .vertical_fov = fov};
}

std::vector<WorldPos> shown(const Scenery& scenery, effects::EffectSet without = 0) {
    std::vector<scene::Instance> instances;
    std::vector<animation::ModelState> models;
    scenery.show(instances, models, without);
    std::vector<WorldPos> places;
    for (const scene::Instance& instance : instances) places.push_back(instance.position);
    return places;
}

TEST(Scenery, of_a_world_that_calls_for_none_is_nothing) {
    const auto world = make_world(0, 0);
    const auto scenery = *Scenery::make(*world);
    for (int t = 0; t < 10; ++t) scenery->tick(looking_from({0.0, 2.0, 0.0}));
    EXPECT_TRUE(shown(*scenery).empty());
    const effects::Simulations work = scenery->take_work();
    for (const EffectId id : {EffectId::birds, EffectId::rigid_bodies}) EXPECT_EQ(work[id], effects::Simulation{});
}

TEST(Scenery, birds_keep_near_their_place_and_apart) {
    const auto world = make_world(20, 0);
    const auto scenery = *Scenery::make(*world);
    std::vector<WorldPos> before = shown(*scenery);
    ASSERT_EQ(before.size(), 20u);
    double nearest_sum = 0.0;
    for (int t = 0; t < 60 * kTicks; ++t) {
        scenery->tick(looking_from({0.0, 2.0, 0.0}));
        const std::vector<WorldPos> now = shown(*scenery);
        for (std::size_t i = 0; i < now.size(); ++i) {
            const double speed = glm::distance(now[i], before[i]) * kTicksPerSecond;
            ASSERT_GT(speed, 4.9);
            ASSERT_LT(speed, 11.1);
            ASSERT_LT(glm::distance(now[i], WorldPos(0.0, 40.0, 0.0)), 90.0) << "bird " << i << " at tick " << t;
        }
        if (t % kTicks == 0)
            for (std::size_t i = 0; i < now.size(); ++i) {
                double nearest = 1e9;
                for (std::size_t j = 0; j < now.size(); ++j)
                    if (j != i) nearest = std::min(nearest, glm::distance(now[i], now[j]));
                nearest_sum += nearest;
            }
        before = now;
    }
    const double nearest = nearest_sum / (60.0 * 20.0);
    EXPECT_GT(nearest, 1.0) << "they do not fly in a heap";
    EXPECT_LT(nearest, 12.0) << "nor each for itself";
    EXPECT_EQ(scenery->take_work()[EffectId::birds].moving, 20u);
}

TEST(Scenery, far_flocks_stand_still_unseen_but_for_who_magnifies) {
    const auto world = make_world(8, 0);
    const auto scenery = *Scenery::make(*world, {.birds_within_m = 100.0});
    const WorldPos far(500.0, 2.0, 0.0);
    const std::vector<WorldPos> start = shown(*scenery);
    scenery->tick(looking_from(far));
    EXPECT_EQ(scenery->take_work()[EffectId::birds].moving, 0u);
    EXPECT_TRUE(shown(*scenery).empty());
    scenery->tick(looking_from(far, radians_of(5.0)));
    EXPECT_EQ(scenery->take_work()[EffectId::birds].moving, 8u);
    const std::vector<WorldPos> now = shown(*scenery);
    ASSERT_EQ(now.size(), 8u);
    EXPECT_LT(glm::distance(now[0], start[0]), 0.1) << "no time has passed for them";
}

TEST(Scenery, bodies_fall_come_to_rest_and_are_held_where_nobody_is_near) {
    const auto world = make_world(0, 3);
    const auto scenery = *Scenery::make(*world, {.bodies_within_m = 50.0});
    const std::vector<WorldPos> start = shown(*scenery);
    for (int t = 0; t < kTicks; ++t) scenery->tick(looking_from({150.0, 2.0, 0.0}));
    EXPECT_EQ(shown(*scenery), start);
    EXPECT_EQ(scenery->take_work()[EffectId::rigid_bodies].moving, 0u);
    scenery->tick(looking_from({30.0, 2.0, 0.0}));
    EXPECT_EQ(scenery->take_work()[EffectId::rigid_bodies].moving, 3u);
    for (int t = 0; t < 10 * kTicks; ++t) scenery->tick(looking_from({30.0, 2.0, 0.0}));
    EXPECT_EQ(scenery->take_work()[EffectId::rigid_bodies].moving, 0u) << "asleep";
    for (const WorldPos& at : shown(*scenery)) {
        EXPECT_GT(at.y, 0.4);
        EXPECT_LT(at.y, 2.7);
    }
}

TEST(Scenery, that_is_switched_off_is_not_there_or_stands) {
    const auto world = make_world(8, 2);
    const effects::EffectSet both = effects::set_of(EffectId::birds) | effects::set_of(EffectId::rigid_bodies);
    const auto scenery = *Scenery::make(*world), off = *Scenery::make(*world, {}, both);
    for (int t = 0; t < 2 * kTicks; ++t) {
        scenery->tick(looking_from({0.0, 2.0, 0.0}));
        off->tick(looking_from({0.0, 2.0, 0.0}));
    }
    EXPECT_EQ(shown(*scenery).size(), 10u);
    const std::vector<WorldPos> standing{world->info().loose_bodies[0].model.position,
                                         world->info().loose_bodies[1].model.position};
    EXPECT_EQ(shown(*scenery, both), standing) << "for a frame";
    EXPECT_EQ(shown(*off), standing) << "for good";
    const effects::Simulations work = off->take_work();
    for (const EffectId id : {EffectId::birds, EffectId::rigid_bodies}) {
        EXPECT_TRUE(work[id].is_called_for);
        EXPECT_EQ(work[id].systems, 0u);
        EXPECT_EQ(work[id].ms, 0.0);
    }
}

TEST(Scenery, goes_the_same_way_again_after_a_reset) {
    const auto world = make_world(10, 3);
    const auto scenery = *Scenery::make(*world);
    const std::vector<WorldPos> start = shown(*scenery);
    const auto go = [&] {
        for (int t = 0; t < 3 * kTicks; ++t) scenery->tick(looking_from({0.0, 2.0, 0.0}));
        return shown(*scenery);
    };
    const std::vector<WorldPos> end = go();
    EXPECT_NE(end, start);
    scenery->reset();
    EXPECT_EQ(scenery->ticks(), 0u);
    EXPECT_EQ(shown(*scenery), start);
    EXPECT_EQ(go(), end);
}

TEST(Scenery, the_number_of_workers_changes_no_bit) {
    const auto world = make_world(30, 4);
    std::vector<WorldPos> places[2];
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        const auto scenery = *Scenery::make(*world);
        for (int t = 0; t < 5 * kTicks; ++t) scenery->tick(looking_from({0.0, 2.0, 0.0}));
        places[workers - 1] = shown(*scenery);
    }
    EXPECT_EQ(places[0], places[1]);
}

TEST(LooseBodies, have_the_hull_and_the_origin_of_their_largest_part) {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    scene::MeshSource small, large;
    test::append_box(small, Vec3(-0.1f), Vec3(0.1f), 1, 0);
    test::append_box(large, Vec3(-1.0f), Vec3(1.0f), 1, 0);
    for (const scene::MeshSource& mesh : {small, large}) (void)data.add_mesh(scene::prepare_mesh(mesh, data.materials));
    data.finish(64);
    scene::WorldInfo info;
    info.dynamic_instances = {{.mesh = 0, .position = {0, 2, 0}}, {.mesh = 1, .position = {0, 5, 0}}};
    info.loose_bodies = {{{.position = {0, 4, 0}, .yaw = 1.0, .first_instance = 0, .instance_count = 2}, 7.0f}};
    const scene::World world(std::move(data), std::move(info));
    const LooseBodyStart start = start_of(world, world.info().loose_bodies[0]);
    EXPECT_EQ(start.desc.shape.mesh, 1u);
    EXPECT_EQ(start.desc.mass_kg, 7.0f);
    EXPECT_EQ(start.desc.pose.position, WorldPos(0, 5, 0));
    // Shown where the body is at first, all parts are where the world has them.
    std::vector<scene::Instance> instances;
    std::vector<animation::ModelState> models;
    show_model(world, start.model, start.desc.pose.position, start.desc.pose.rotation, 0.0, instances, models);
    ASSERT_EQ(instances.size(), 2u);
    EXPECT_LT(glm::distance(instances[0].position, WorldPos(0, 2, 0)), 1e-6);
    EXPECT_LT(glm::distance(instances[1].position, WorldPos(0, 5, 0)), 1e-6);
}

}  // namespace
}  // namespace ff::scenery
