#include "engine/ecs/transform_hierarchy.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>

namespace ff::ecs {
namespace {

Entity create_at(Registry& registry, const DVec3& position) {
    LocalTransform local;
    local.position = position;
    return registry.create(local, WorldTransform{});
}

TEST(TransformHierarchy, a_child_follows_its_turned_and_scaled_parent) {
    Registry registry;
    TransformHierarchy hierarchy;
    const Entity parent = create_at(registry, {1e6, 0, 0}), child = create_at(registry, {0, 0, -2});
    ASSERT_TRUE(hierarchy.set_parent(registry, child, parent));
    LocalTransform* local = registry.get<LocalTransform>(parent);
    local->rotation = glm::angleAxis(float(kPi / 2), Vec3(0, 1, 0));  // -z becomes -x
    local->scale = Vec3(3.0f);
    hierarchy.update(registry);
    EXPECT_NEAR(registry.get<WorldTransform>(child)->position.x, 1e6 - 6.0, 1e-5);
    EXPECT_NEAR(registry.get<WorldTransform>(child)->position.z, 0.0, 1e-5);
    EXPECT_EQ(hierarchy.deepest(), 1);
    ASSERT_TRUE(hierarchy.set_parent(registry, child, {}));
    hierarchy.update(registry);
    EXPECT_EQ(registry.get<WorldTransform>(child)->position.z, -2.0);
}

TEST(TransformHierarchy, cycles_and_dead_entities_are_refused) {
    Registry registry;
    TransformHierarchy hierarchy;
    const Entity a = create_at(registry, {}), b = create_at(registry, {}), c = create_at(registry, {});
    ASSERT_TRUE(hierarchy.set_parent(registry, b, a));
    ASSERT_TRUE(hierarchy.set_parent(registry, c, b));
    EXPECT_FALSE(hierarchy.set_parent(registry, a, a));
    const Status cycle = hierarchy.set_parent(registry, a, c);
    ASSERT_FALSE(cycle);
    EXPECT_NE(cycle.error().message.find("cycle"), std::string::npos);
    EXPECT_EQ(registry.get<Parent>(a), nullptr);
    registry.destroy(b);
    EXPECT_FALSE(hierarchy.set_parent(registry, a, b));
    EXPECT_FALSE(hierarchy.set_parent(registry, b, a));
}

TEST(TransformHierarchy, children_of_the_dead_are_roots) {
    Registry registry;
    TransformHierarchy hierarchy;
    const Entity a = create_at(registry, {5, 0, 0}), b = create_at(registry, {1, 0, 0});
    ASSERT_TRUE(hierarchy.set_parent(registry, b, a));
    hierarchy.update(registry);
    EXPECT_EQ(registry.get<WorldTransform>(b)->position.x, 6.0);
    registry.destroy(a);
    create_at(registry, {100, 0, 0});  // takes a's slot, but is not a
    hierarchy.update(registry);
    EXPECT_EQ(registry.get<WorldTransform>(b)->position.x, 1.0);
    EXPECT_EQ(hierarchy.deepest(), 0);
}

TEST(TransformHierarchy, a_subtree_is_destroyed_whole_and_alone) {
    Registry registry;
    TransformHierarchy hierarchy;
    std::vector<Entity> chain;
    for (int i = 0; i < 10; ++i) {
        chain.push_back(create_at(registry, {1, 0, 0}));
        if (i > 0) {
            ASSERT_TRUE(hierarchy.set_parent(registry, chain.back(), chain[std::size_t((i - 1) / 2)]));
        }
    }
    const Entity beside = create_at(registry, {});
    EXPECT_EQ(hierarchy.destroy_subtree(registry, chain[0]), 10u);
    EXPECT_TRUE(registry.is_alive(beside));
    EXPECT_EQ(registry.size(), 1u);
    EXPECT_EQ(hierarchy.destroy_subtree(registry, chain[0]), 0u);
}

TEST(TransformHierarchy, random_forests_match_the_walk_up_to_the_root) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> unit(-1.0, 1.0);
        Registry registry;
        TransformHierarchy hierarchy;
        std::vector<Entity> entities;
        for (int i = 0; i < 300; ++i) {
            entities.push_back(create_at(registry, DVec3(unit(random), unit(random), unit(random)) * 100.0));
            LocalTransform* local = registry.get<LocalTransform>(entities.back());
            local->rotation =
                glm::normalize(glm::quat(float(unit(random)), float(unit(random)), float(unit(random)), 2.0f));
            local->scale = Vec3(float(1.0 + 0.3 * unit(random)));
        }
        for (int i = 0; i < 600; ++i) {
            // Many of these are refused, as they would close a cycle.
            const Entity child = entities[random() % entities.size()], parent = entities[random() % entities.size()];
            (void)bool(hierarchy.set_parent(registry, child, parent));
            if (i % 50 == 0) hierarchy.update(registry);
        }
        for (int i = 0; i < 30; ++i) registry.destroy(entities[random() % entities.size()]);
        hierarchy.update(registry);
        for (const Entity entity : entities) {
            if (!registry.is_alive(entity)) continue;
            DVec3 point(0.0);
            for (Entity at = entity; registry.is_alive(at);) {
                const LocalTransform& local = *registry.get<LocalTransform>(at);
                point = local.position + DMat3(glm::mat3_cast(local.rotation)) * (DVec3(local.scale) * point);
                const Parent* parent = registry.get<Parent>(at);
                at = parent ? parent->entity : Entity{};
            }
            const DVec3 found = registry.get<WorldTransform>(entity)->position;
            ASSERT_LT(glm::length(found - point), 1e-4 * (1.0 + glm::length(point)));
        }
    }
}

}  // namespace
}  // namespace ff::ecs
