// A steady tick asks for no memory, and neither does Bullet within it.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

#include "engine/core/sanitizers.h"
#include "tests/physics/physics_worlds.h"

#if defined(__GLIBC__) && !defined(FF_SANITIZES_MEMORY)
#define FF_COUNTS_ALLOCATIONS 1
#endif

namespace {
std::atomic<std::uint64_t> g_allocations{0};
}

#ifdef FF_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);

// glibc's documented way to replace malloc; new asks it in turn.
void* malloc(std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_calloc(number, size);
}
void* realloc(void* old, std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_realloc(old, size);
}
}
#endif

namespace ff::test {
namespace {

TEST(Allocations, a_steady_tick_and_its_hash_make_none) {
#ifndef FF_COUNTS_ALLOCATIONS
    GTEST_SKIP() << "malloc cannot be replaced here";
#endif
    Walled w(Ground().floor(30).stairs(10, 0.2f, 0.4f).finish());
    Random random(1);
    std::vector<physics::BodyId> bodies;
    for (int i = 0; i < 40; ++i) {
        physics::BodyDesc desc;
        if (i % 3 == 0) desc.shape = physics::box_shape(Vec3(0.3f));
        if (i % 3 == 1) desc.shape = physics::sphere_shape(0.3f);
        if (i % 3 == 2) desc.shape = physics::capsule_shape(0.2f, 0.3f);
        desc.pose.position = WorldPos(random.in_box({-4, 1, -4}, {4, 6, 4}));
        bodies.push_back(*w.world.add_body(desc));
    }
    const physics::CharacterId id = w.walker({-2, 0, 0});
    const auto play = [&](int ticks) {
        for (int i = 0; i < ticks; ++i) {
            (void)bool(w.world.set_input(id, {.velocity_m_s = {float(3 * std::cos(i * 0.02)), 0, 1}}));
            if (i % 40 == 0)
                for (const physics::BodyId body : bodies)
                    (void)bool(w.world.set_velocity(body, {0.5f, 3, 0.2f}, {1, 0, 0}));
            w.world.step();
            (void)w.world.hash();
        }
    };
    play(1200);
    const std::uint64_t before = g_allocations.load();
    play(400);
    EXPECT_LE(g_allocations.load() - before, 3u) << "scratch that still grows is rare; a tick's own would be hundreds";
}

}  // namespace
}  // namespace ff::test
