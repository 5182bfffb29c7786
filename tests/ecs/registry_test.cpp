// The registry against a naive model, and its promises about handles, moves and iteration.
#include "engine/ecs/registry.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <string>

#include "engine/ecs/commands.h"

namespace ff::ecs {
namespace {

struct Position {
    float x = 0, y = 0, z = 0;
};
struct Velocity {
    float x = 0, y = 0, z = 0;
};
struct Hidden {};
struct Name {
    std::string text;  // not trivially copyable: long ones own memory
};
struct Wide {
    alignas(32) double values[8]{};
};

TEST(Registry, a_stale_handle_does_nothing) {
    Registry registry;
    EXPECT_FALSE(registry.is_alive({}));
    const Entity first = registry.create(Position{1, 2, 3});
    EXPECT_TRUE(registry.destroy(first));
    EXPECT_FALSE(registry.destroy(first));
    const Entity second = registry.create(Position{4, 5, 6});
    EXPECT_EQ(second.index, first.index);
    EXPECT_NE(second, first);
    EXPECT_FALSE(registry.is_alive(first));
    EXPECT_EQ(registry.get<Position>(first), nullptr);
    EXPECT_EQ(registry.add(first, Velocity{}), nullptr);
    EXPECT_FALSE(registry.remove<Position>(first));
    EXPECT_FALSE(registry.is_alive({second.index + 1000, 1}));
    EXPECT_EQ(registry.get<Position>(second)->y, 5.0f);
    EXPECT_EQ(registry.size(), 1u);
}

TEST(Registry, components_can_be_added_replaced_and_removed) {
    Registry registry;
    const Entity entity = registry.create();
    EXPECT_FALSE(registry.has<Name>(entity));
    registry.add(entity, Name{std::string(100, 'a')});
    registry.add(entity, Position{1, 2, 3});
    registry.add(entity, Hidden{});
    EXPECT_EQ(registry.get<Name>(entity)->text, std::string(100, 'a'));
    registry.add(entity, Name{std::string(200, 'b')});
    EXPECT_EQ(registry.get<Name>(entity)->text, std::string(200, 'b'));
    EXPECT_TRUE(registry.has<Hidden>(entity));
    EXPECT_TRUE(registry.remove<Position>(entity));
    EXPECT_FALSE(registry.remove<Position>(entity));
    EXPECT_EQ(registry.get<Name>(entity)->text, std::string(200, 'b'));
    EXPECT_TRUE(registry.remove<Name>(entity));
    EXPECT_TRUE(registry.has<Hidden>(entity));
    EXPECT_TRUE(registry.is_alive(entity));
}

TEST(Registry, move_only_components_are_kept_and_destroyed_once) {
    const auto counted = std::make_shared<int>(0);
    struct Owner {
        std::shared_ptr<int> shared;
        std::unique_ptr<int> own;
    };
    {
        Registry registry;
        std::vector<Entity> entities;
        for (int i = 0; i < 2000; ++i) entities.push_back(registry.create(Owner{counted, std::make_unique<int>(i)}));
        for (int i = 0; i < 2000; i += 3) registry.destroy(entities[std::size_t(i)]);
        for (int i = 1; i < 2000; i += 3) registry.add(entities[std::size_t(i)], Wide{});
        for (int i = 0; i < 2000; ++i) {
            const Owner* owner = registry.get<Owner>(entities[std::size_t(i)]);
            ASSERT_EQ(owner != nullptr, i % 3 != 0);
            if (owner) {
                ASSERT_EQ(*owner->own, i);
            }
        }
        EXPECT_EQ(std::size_t(counted.use_count()), registry.size() + 1);
    }
    EXPECT_EQ(counted.use_count(), 1);
}

TEST(Registry, behaves_like_a_map_of_optional_components) {
    struct Model {
        std::optional<float> position;
        std::optional<std::string> name;
        bool hidden = false;
    };
    for (unsigned seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        Registry registry;
        std::map<Entity, Model> model;
        std::vector<Entity> dead;
        const auto any = [&] { return std::next(model.begin(), long(random() % model.size()))->first; };
        for (int step = 0; step < 3000; ++step) {
            const auto action = random() % 10;
            const float value = float(random() % 1000);
            if (action < 3 || model.empty()) {
                if (random() % 2) {
                    model[registry.create(Position{value, 0, 0})] = {value, {}, false};
                } else {
                    model[registry.create(Name{std::to_string(value)}, Hidden{})] = {{}, std::to_string(value), true};
                }
            } else if (action < 5) {
                const Entity entity = any();
                ASSERT_TRUE(registry.destroy(entity));
                model.erase(entity);
                dead.push_back(entity);
            } else if (action < 6) {
                const Entity entity = any();
                registry.add(entity, Position{value, 0, 0});
                model[entity].position = value;
            } else if (action < 7) {
                const Entity entity = any();
                registry.add(entity, Name{std::to_string(value)});
                model[entity].name = std::to_string(value);
            } else if (action < 8) {
                const Entity entity = any();
                ASSERT_EQ(registry.remove<Position>(entity), model[entity].position.has_value());
                model[entity].position.reset();
            } else if (action < 9) {
                const Entity entity = any();
                ASSERT_EQ(registry.remove<Name>(entity), model[entity].name.has_value());
                model[entity].name.reset();
            } else {
                const Entity entity = any();
                ASSERT_EQ(registry.remove<Hidden>(entity), model[entity].hidden);
                model[entity].hidden = false;
            }
        }
        ASSERT_EQ(registry.size(), model.size());
        for (const Entity entity : dead) ASSERT_FALSE(registry.is_alive(entity));
        for (const auto& [entity, expected] : model) {
            const Position* position = registry.get<Position>(entity);
            const Name* name = registry.get<Name>(entity);
            ASSERT_EQ(position != nullptr, expected.position.has_value());
            ASSERT_EQ(name != nullptr, expected.name.has_value());
            ASSERT_EQ(registry.has<Hidden>(entity), expected.hidden);
            if (position) {
                ASSERT_EQ(position->x, *expected.position);
            }
            if (name) {
                ASSERT_EQ(name->text, *expected.name);
            }
        }
        // Queries see exactly the entities that match, each once.
        std::size_t visible = 0, expected_visible = 0;
        registry.each_chunk<const Position, Without<Hidden>>(
            [&](std::span<const Entity> entities, std::span<const Position> positions) {
                for (std::size_t i = 0; i < entities.size(); ++i) {
                    ++visible;
                    ASSERT_TRUE(model.contains(entities[i]));
                    ASSERT_EQ(*model[entities[i]].position, positions[i].x);
                    ASSERT_FALSE(model[entities[i]].hidden);
                }
            });
        for (const auto& [entity, expected] : model) expected_visible += expected.position && !expected.hidden ? 1 : 0;
        ASSERT_EQ(visible, expected_visible);
    }
}

TEST(Registry, chunks_are_aligned_and_cover_every_entity_once) {
    Registry registry;
    std::vector<Entity> entities;
    for (int i = 0; i < 10000; ++i) entities.push_back(registry.create(Position{float(i), 0, 0}, Wide{}, Velocity{}));
    for (int i = 0; i < 10000; i += 7) registry.destroy(entities[std::size_t(i)]);
    std::size_t count = 0;
    registry.each_chunk<Position, const Velocity, const Wide>([&](std::span<const Entity> chunk, std::span<Position> p,
                                                                  std::span<const Velocity> v,
                                                                  std::span<const Wide> w) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(p.data()) % 64, 0u);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(v.data()) % 64, 0u);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(w.data()) % 64, 0u);
        EXPECT_EQ(p.size(), chunk.size());
        for (Position& each : p) each.y += 1.0f;
        count += p.size();
    });
    EXPECT_EQ(count, registry.size());
    registry.each_chunk_parallel<Position>([](std::span<const Entity>, std::span<Position> p) {
        for (Position& each : p) each.y += 1.0f;
    });
    registry.each<const Position>([](const Position& p) { ASSERT_EQ(p.y, 2.0f); });
}

TEST(RegistryDeathTest, structural_changes_while_iterating_are_refused) {
    Registry registry;
    registry.create(Position{});
    EXPECT_DEATH(registry.each<Position>([&](Position&) { registry.create(Position{}); }), "Commands");
}

TEST(Registry, events_can_be_read_for_exactly_one_tick) {
    Registry registry;
    registry.events<int>().send(1);
    registry.events<int>().send(2);
    EXPECT_TRUE(registry.events<int>().read().empty());
    registry.swap_events();
    registry.events<int>().send(3);
    ASSERT_EQ(registry.events<int>().read().size(), 2u);
    EXPECT_EQ(registry.events<int>().read()[1], 2);
    registry.swap_events();
    ASSERT_EQ(registry.events<int>().read().size(), 1u);
    registry.swap_events();
    EXPECT_TRUE(registry.events<int>().read().empty());
}

TEST(Commands, are_made_in_order_and_understand_entities_to_come) {
    Registry registry;
    Commands commands;
    const Entity old = registry.create(Position{7, 0, 0});
    registry.each<const Position>([&](const Position&) {
        const Entity to_come = commands.create(Position{1, 0, 0}, Name{std::string(50, 'x')});
        EXPECT_FALSE(registry.is_alive(to_come));
        commands.add(to_come, Velocity{2, 0, 0});
        commands.remove<Position>(to_come);
        const Entity short_lived = commands.create(Position{});
        commands.destroy(short_lived);
        commands.add(short_lived, Hidden{});
        commands.destroy(old);
        commands.add(old, Hidden{});
    });
    EXPECT_EQ(registry.size(), 1u);
    commands.apply(registry);
    EXPECT_TRUE(commands.empty());
    EXPECT_EQ(registry.size(), 1u);
    EXPECT_FALSE(registry.is_alive(old));
    int seen = 0;
    registry.each<const Velocity, const Name, Without<Position>>([&](const Velocity& velocity, const Name& name) {
        ++seen;
        EXPECT_EQ(velocity.x, 2.0f);
        EXPECT_EQ(name.text, std::string(50, 'x'));
    });
    EXPECT_EQ(seen, 1);
    commands.create(Name{std::string(60, 'y')});  // never applied: must not leak
}

}  // namespace
}  // namespace ff::ecs
