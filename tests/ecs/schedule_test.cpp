// Systems in parallel give what they would give one after the other.
#include "engine/ecs/schedule.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <random>

#include "engine/core/hash.h"
#include "engine/core/jobs.h"

namespace ff::ecs {
namespace {

struct A {
    double value = 0;
};
struct B {
    double value = 0;
};
struct C {
    double value = 0;
};
struct Total {
    double sum = 0;
};
struct Collision {
    Entity entity;
    double strength;
};

TEST(Schedule, only_conflicting_systems_wait_for_each_other) {
    Schedule schedule;
    const auto nothing = [](SystemContext&) {};
    schedule.add("writes a", Access().write<A>(), nothing);
    schedule.add("writes b", Access().write<B>(), nothing);
    schedule.add("reads a", Access().read<A>(), nothing);
    schedule.add("reads a too", Access().read<A>().write<C>(), nothing);
    schedule.add("writes a again", Access().write<A>(), nothing);
    schedule.add("sends", Access().send<Collision>(), nothing);
    schedule.add("receives", Access().receive<Collision>(), nothing);
    schedule.add("sends too", Access().send<Collision>(), nothing);
    const auto waits = [&](std::size_t i) {
        return std::vector<std::uint32_t>(schedule.predecessors(i).begin(), schedule.predecessors(i).end());
    };
    using List = std::vector<std::uint32_t>;
    EXPECT_EQ(waits(1), List{});
    EXPECT_EQ(waits(2), List{0});
    EXPECT_EQ(waits(3), List{0});
    EXPECT_EQ(waits(4), (List{0, 2, 3}));
    EXPECT_EQ(waits(6), List{});
    EXPECT_EQ(waits(7), List{5});
}

TEST(ScheduleDeathTest, what_was_not_declared_may_not_be_touched) {
    Registry registry;
    registry.create(A{}, B{});
    Schedule schedule;
    schedule.add("sneaky", Access().read<A>(), [](SystemContext& context) { context.each<A>([](A&) {}); });
    EXPECT_DEATH(schedule.run(registry), "sneaky");
}

TEST(Schedule, commands_are_applied_at_barriers_and_at_the_end) {
    Registry registry;
    Schedule schedule;
    std::vector<int> counts;
    const auto count = [&](SystemContext& context) {
        int n = 0;
        context.each<const A>([&](const A&) { ++n; });
        counts.push_back(n);
    };
    schedule.add("spawn", Access(), [](SystemContext& context) { context.commands().create(A{1}); });
    schedule.add("count", Access().read<A>(), count);
    schedule.add_barrier();
    schedule.add("count after", Access().read<A>(), count);
    schedule.add("spawn more", Access(), [](SystemContext& context) { context.commands().create(A{1}); });
    schedule.run(registry);
    EXPECT_EQ(counts, (std::vector<int>{0, 1}));
    EXPECT_EQ(registry.size(), 2u);
}

/// A small simulation in which systems create, destroy, send, and depend on each other's results.
std::uint64_t hash_of_world_after(int ticks, int workers) {
    const WorkerLimit limit(workers);
    Registry registry;
    std::mt19937 random(5);
    for (int i = 0; i < 3000; ++i) {
        const double value = double(random() % 1000) * 0.001;
        if (i % 3 == 0)
            registry.create(A{value}, B{value * 2});
        else if (i % 3 == 1)
            registry.create(A{value}, C{1 - value});
        else
            registry.create(A{value}, B{1}, C{value});
    }
    Schedule schedule;
    schedule.add("move", Access().write<A>().read<B>(), [](SystemContext& context) {
        context.each_chunk_parallel<A, const B>([](std::span<const Entity>, std::span<A> a, std::span<const B> b) {
            for (std::size_t i = 0; i < a.size(); ++i) a[i].value += 0.01 * b[i].value;
        });
    });
    schedule.add("spin", Access().write<C>(),
                 [](SystemContext& context) { context.each<C>([](C& c) { c.value = c.value * 1.01 - 0.005; }); });
    schedule.add("hit", Access().read<A, C>().send<Collision>(), [](SystemContext& context) {
        context.each_chunk<const A, const C>(
            [&](std::span<const Entity> entities, std::span<const A> a, std::span<const C> c) {
                for (std::size_t i = 0; i < entities.size(); ++i)
                    if (a[i].value > c[i].value) context.send(Collision{entities[i], a[i].value});
            });
    });
    schedule.add("spawn", Access().read<B>(), [](SystemContext& context) {
        context.each<const B>([&](const B& b) {
            if (b.value > 0.99 && b.value < 1.0) context.commands().create(A{b.value}, B{0.5}, C{0.1});
        });
    });
    schedule.add("fade", Access().write<B>(),
                 [](SystemContext& context) { context.each<B>([](B& b) { b.value *= 0.99; }); });
    schedule.add("damage", Access().receive<Collision>().write_resource<Total>(), [](SystemContext& context) {
        for (const Collision& collision : context.received<Collision>()) {
            context.resource<Total>().sum += collision.strength;
            if (collision.strength > 0.9) context.commands().destroy(collision.entity);
        }
    });
    for (int tick = 0; tick < ticks; ++tick) {
        schedule.run(registry);
        registry.swap_events();
    }
    std::vector<double> state{registry.resource<Total>().sum, double(registry.size())};
    registry.each_chunk<const A>([&](std::span<const Entity> entities, std::span<const A> a) {
        for (std::size_t i = 0; i < a.size(); ++i) {
            state.push_back(a[i].value);
            state.push_back(double(entities[i].index) + double(entities[i].generation) * 1e7);
        }
    });
    registry.each<const C>([&](const C& c) { state.push_back(c.value); });
    return hash_bytes(std::as_bytes(std::span(state)));
}

TEST(Schedule, the_number_of_workers_changes_no_bit) {
    const std::uint64_t alone = hash_of_world_after(60, 1);
    for (const int workers : {2, 3, 4})
        for (int repeat = 0; repeat < 3; ++repeat) ASSERT_EQ(hash_of_world_after(60, workers), alone) << workers;
}

}  // namespace
}  // namespace ff::ecs
