// The ECS runtime over 1M entities: nanoseconds per entity to create, destroy and iterate 1, 2 and 5 components.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "engine/ecs/commands.h"
#include "engine/ecs/registry.h"
#include "engine/ecs/transform_hierarchy.h"

namespace {

using namespace ff::ecs;

constexpr std::size_t kEntities = 1'000'000;

template <int kWhich>
struct Vector {
    float x = 1, y = 2, z = 3;
};
using Position = Vector<0>;
using Velocity = Vector<1>;

void per_entity(benchmark::State& state, std::size_t entities = kEntities) {
    state.counters["ns_per_entity"] = benchmark::Counter(
        double(entities) * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// From nothing, memory and all.
void create_with_2_components(benchmark::State& state) {
    for (auto _ : state) {
        Registry registry;
        for (std::size_t i = 0; i < kEntities; ++i) benchmark::DoNotOptimize(registry.create(Position{}, Velocity{}));
        state.PauseTiming();
        benchmark::DoNotOptimize(registry.size());
        state.ResumeTiming();
    }
    per_entity(state);
}
BENCHMARK(create_with_2_components)->Unit(benchmark::kMillisecond);

/// Into memory that the registry already has, as in a running game.
void create_again(benchmark::State& state) {
    Registry registry;
    std::vector<Entity> entities(kEntities);
    for (auto _ : state) {
        for (Entity& entity : entities) entity = registry.create(Position{}, Velocity{});
        state.PauseTiming();
        for (const Entity entity : entities) registry.destroy(entity);
        state.ResumeTiming();
    }
    per_entity(state);
}
BENCHMARK(create_again)->Unit(benchmark::kMillisecond);

void destroy(benchmark::State& state) {
    Registry registry;
    std::vector<Entity> entities(kEntities);
    for (auto _ : state) {
        state.PauseTiming();
        for (Entity& entity : entities) entity = registry.create(Position{}, Velocity{});
        state.ResumeTiming();
        for (const Entity entity : entities) registry.destroy(entity);
    }
    per_entity(state);
}
BENCHMARK(destroy)->Unit(benchmark::kMillisecond);

std::unique_ptr<Registry> world_of(int components) {
    auto registry = std::make_unique<Registry>();
    for (std::size_t i = 0; i < kEntities; ++i) {
        if (components == 1) registry->create(Position{});
        if (components == 2) registry->create(Position{}, Velocity{});
        if (components == 5) registry->create(Position{}, Velocity{}, Vector<2>{}, Vector<3>{}, Vector<4>{});
    }
    return registry;
}

void iterate_1(benchmark::State& state) {
    const auto registry = world_of(1);
    for (auto _ : state)
        registry->each<Position>([](Position& p) {
            p.x += 0.5f;
            p.y += 0.25f;
            p.z -= 0.5f;
        });
    per_entity(state);
}
BENCHMARK(iterate_1)->Unit(benchmark::kMicrosecond);

void iterate_2(benchmark::State& state) {
    const auto registry = world_of(2);
    for (auto _ : state)
        registry->each<Position, const Velocity>([](Position& p, const Velocity& v) {
            p.x += v.x * 0.01f;
            p.y += v.y * 0.01f;
            p.z += v.z * 0.01f;
        });
    per_entity(state);
}
BENCHMARK(iterate_2)->Unit(benchmark::kMicrosecond);

/// What the memory allows: the same loop over two plain arrays.
void iterate_2_plain_arrays(benchmark::State& state) {
    std::vector<Position> positions(kEntities);
    std::vector<Velocity> velocities(kEntities);
    for (auto _ : state) {
        for (std::size_t i = 0; i < kEntities; ++i) {
            positions[i].x += velocities[i].x * 0.01f;
            positions[i].y += velocities[i].y * 0.01f;
            positions[i].z += velocities[i].z * 0.01f;
        }
        benchmark::ClobberMemory();
    }
    per_entity(state);
}
BENCHMARK(iterate_2_plain_arrays)->Unit(benchmark::kMicrosecond);

void iterate_5(benchmark::State& state) {
    const auto registry = world_of(5);
    for (auto _ : state)
        registry->each<Position, const Velocity, const Vector<2>, const Vector<3>, const Vector<4>>(
            [](Position& p, const Velocity& v, const Vector<2>& a, const Vector<3>& b, const Vector<4>& c) {
                p.x += v.x * a.x + b.x * c.x;
                p.y += v.y * a.y + b.y * c.y;
                p.z += v.z * a.z + b.z * c.z;
            });
    per_entity(state);
}
BENCHMARK(iterate_5)->Unit(benchmark::kMicrosecond);

void get_at_random(benchmark::State& state) {
    Registry registry;
    std::vector<Entity> entities;
    for (std::size_t i = 0; i < kEntities; ++i) entities.push_back(registry.create(Position{}, Velocity{}));
    for (auto _ : state) {
        float sum = 0;
        for (std::size_t i = 0; i < kEntities; ++i) sum += registry.get<Position>(entities[i * 7919 % kEntities])->x;
        benchmark::DoNotOptimize(sum);
    }
    per_entity(state);
}
BENCHMARK(get_at_random)->Unit(benchmark::kMillisecond);

void add_and_remove_a_component(benchmark::State& state) {
    Registry registry;
    std::vector<Entity> entities;
    for (std::size_t i = 0; i < kEntities / 10; ++i) entities.push_back(registry.create(Position{}));
    for (auto _ : state) {
        for (const Entity entity : entities) registry.add(entity, Velocity{});
        for (const Entity entity : entities) registry.remove<Velocity>(entity);
    }
    per_entity(state, kEntities / 5);
}
BENCHMARK(add_and_remove_a_component)->Unit(benchmark::kMillisecond);

void create_through_commands(benchmark::State& state) {
    Commands commands;
    for (auto _ : state) {
        Registry registry;
        for (std::size_t i = 0; i < kEntities / 10; ++i) commands.create(Position{}, Velocity{});
        commands.apply(registry);
    }
    per_entity(state, kEntities / 10);
}
BENCHMARK(create_through_commands)->Unit(benchmark::kMillisecond);

void propagate_transforms(benchmark::State& state) {
    Registry registry;
    TransformHierarchy hierarchy;
    std::vector<Entity> entities;
    for (std::size_t i = 0; i < kEntities / 10; ++i) {
        entities.push_back(registry.create(LocalTransform{}, WorldTransform{}));
        if (i % 8 != 0) (void)bool(hierarchy.set_parent(registry, entities.back(), entities[i - 1]));
    }
    for (auto _ : state) hierarchy.update(registry);
    per_entity(state, kEntities / 10);
}
BENCHMARK(propagate_transforms)->Unit(benchmark::kMicrosecond);

}  // namespace
