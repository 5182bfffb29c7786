#include "engine/animation/animator.h"

#include <gtest/gtest.h>

#include "engine/animation/dynamic_models.h"
#include "engine/animation/pose_slots.h"
#include "engine/ecs/transform_hierarchy.h"
#include "tests/support/animated_worlds.h"

namespace ff::animation {
namespace {

TEST(Animator, plays_by_name_and_fades_over_what_was_played) {
    const auto world = test::make_animated_world({.worms = 1, .carts = 0});
    const scene::AnimatedModel& worm = world->info().animation.models[0];
    Animator animator;
    EXPECT_FALSE(play(worm, animator, "no such clip"));
    EXPECT_EQ(animator, Animator{});
    ASSERT_TRUE(play(worm, animator, "bend", {.fade_s = 0.0f}));
    EXPECT_EQ(fade_weight(animator), 1.0f);
    advance(animator, 0.5);
    ASSERT_TRUE(play(worm, animator, "stretch", {.fade_s = 0.4f, .speed = 2.0f}));
    EXPECT_EQ(fade_weight(animator), 0.0f);
    advance(animator, 0.1);
    EXPECT_NEAR(fade_weight(animator), 0.25f, 1e-5f);
    EXPECT_NEAR(animator.before.time_s, 0.6, 1e-9);
    EXPECT_NEAR(animator.now.time_s, 0.2, 1e-9);
    advance(animator, 1.0);
    EXPECT_EQ(fade_weight(animator), 1.0f);
}

TEST(Animator, a_system_moves_all_and_models_are_gathered_in_order) {
    ecs::Registry registry;
    for (int i = 0; i < 100; ++i)
        registry.create(ecs::WorldTransform{.position = WorldPos(i, 0, 0)},
                        Animator{.now = {.clip = 0, .speed = float(i)}});
    registry.create(ecs::WorldTransform{});
    ecs::Schedule schedule;
    schedule.add("animate", advance_access(), [](ecs::SystemContext& context) { advance_animators(context, 0.5); });
    schedule.run(registry);
    advance_animators(registry, 0.5);
    std::vector<ModelState> models;
    gather_models(registry, models);
    ASSERT_EQ(models.size(), 100u);
    for (int i = 0; i < 100; ++i) {
        EXPECT_EQ(models[std::size_t(i)].position.x, double(i));
        EXPECT_NEAR(models[std::size_t(i)].animator.now.time_s, double(i), 1e-9);
    }
}

PoseRequest request(double time_s, double distance_m, std::uint32_t owner) {
    return {.key = {Animator{.now = {.clip = 0, .time_s = time_s}}}, .distance_m = distance_m, .owner = owner};
}

TEST(PoseSlots, equal_poses_share_and_poses_at_hand_are_kept) {
    PoseSlotTable table(3);
    std::vector<PoseRequest> first{request(1, 30, 0), request(2, 10, 1), request(1, 20, 2)};
    table.assign(first);
    EXPECT_EQ(first[0].owner, 1u);
    EXPECT_TRUE(first[0].must_pose);
    EXPECT_EQ(first[1].slot, first[2].slot);
    EXPECT_NE(first[0].must_pose, false);
    EXPECT_EQ(int(first[1].must_pose) + int(first[2].must_pose), 1);
    std::vector<PoseRequest> second{request(3, 5, 0), request(2, 10, 1), request(1, 20, 2)};
    table.assign(second);
    EXPECT_TRUE(second[0].must_pose);
    EXPECT_FALSE(second[1].must_pose);
    EXPECT_FALSE(second[2].must_pose);
    EXPECT_EQ(second[1].slot, first[0].slot);
}

TEST(PoseSlots, when_there_are_too_few_the_farthest_borrow) {
    PoseSlotTable table(2);
    std::vector<PoseRequest> requests{request(1, 1, 0), request(2, 2, 1), request(3, 3, 2), request(4, 4, 3)};
    table.assign(requests);
    EXPECT_FALSE(requests[0].is_borrowed || requests[1].is_borrowed);
    EXPECT_TRUE(requests[2].is_borrowed && requests[3].is_borrowed);
    EXPECT_EQ(requests[3].slot, requests[1].slot);
    // What was far a moment ago keeps nothing from what is near now.
    std::vector<PoseRequest> next{request(3, 1, 0), request(4, 2, 1), request(1, 3, 2), request(2, 4, 3)};
    table.assign(next);
    EXPECT_TRUE(next[0].must_pose && next[1].must_pose);
    EXPECT_TRUE(next[2].is_borrowed && next[3].is_borrowed);
}

}  // namespace
}  // namespace ff::animation
