// Steady frames allocate nothing. Drivers do as they like (llvmpipe allocates for every scene that it bins), so only
// calls from this program's own code count, which has the engine linked into it.

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <new>

#include "engine/core/sanitizers.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/visibility/culler.h"
#include "tests/gl/gl_fixture.h"
#include "tests/support/town.h"

#if defined(__GLIBC__) && !defined(FF_SANITIZES_MEMORY)
#define FF_COUNTS_ALLOCATIONS 1
#endif

namespace {
[[maybe_unused]] std::atomic<std::uint64_t> g_ours{0}, g_others{0};
}

#ifdef FF_COUNTS_ALLOCATIONS
extern "C" {
extern const char __executable_start, etext;  // put there by the linker
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
}

namespace {
void count(const void* caller) {
    const auto* at = static_cast<const char*>(caller);
    (at >= &__executable_start && at < &etext ? g_ours : g_others).fetch_add(1, std::memory_order_relaxed);
}
}  // namespace

// glibc's documented way to replace malloc, and C++'s to replace new, so that the caller is known.
extern "C" {
void* malloc(std::size_t size) {
    count(__builtin_return_address(0));
    return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
    count(__builtin_return_address(0));
    return __libc_calloc(number, size);
}
void* realloc(void* old, std::size_t size) {
    count(__builtin_return_address(0));
    return __libc_realloc(old, size);
}
}
void* operator new(std::size_t size) {
    count(__builtin_return_address(0));
    if (void* memory = __libc_malloc(size)) return memory;
    std::abort();
}
// Not inlined: else the compiler sees memory of our operator new go to free(), and warns.
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
#endif

namespace ff::nearfield {
namespace {

using AllocationTest = test::GlTest;

/// Allocations of a frame of a slow walk, once the buffers have grown.
template <class Render>
void expect_no_allocations(const scene::StaticScene& scene, Render&& render) {
    const visibility::Culler culler(scene);
    visibility::VisibleSet visible;
    std::uint64_t before = 0, others_before = 0;
    constexpr int kWarmUpFrames = 8, kFrames = 20;
    for (int f = 0; f < kFrames; ++f) {
        // Back and forth, so that no buffer has to grow after the first lap.
        const double step = f % kWarmUpFrames;
        const PinholeView view = make_view({.position = {0.5, 1.7, 60.0 - step}, .yaw = 0.02 * step}, 320, 240);
        if (f == kWarmUpFrames) {
            before = g_ours;
            others_before = g_others;
        }
        culler.cull(view, {}, visible);
        ASSERT_TRUE(render(view, DrawSet{.instances = visible.instances}));
    }
    EXPECT_EQ(g_ours - before, 0u);
    testing::Test::RecordProperty("driver_allocations_per_frame",
                                  int((g_others - others_before) / (kFrames - kWarmUpFrames)));
}

TEST_F(AllocationTest, a_steady_frame_of_ids_or_of_a_shaded_picture_allocates_nothing) {
#ifdef FF_COUNTS_ALLOCATIONS
    const std::uint64_t before = g_ours;
    const scene::SceneData world = test::make_small_town({.glass = true});
    EXPECT_GT(g_ours - before, 100u) << "the count works";
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    NearStats stats;
    farfield::VisibilityBuffer buffer;
    shading::Image image;
    for (const bool occlusion : {false, true}) {
        SCOPED_TRACE(occlusion);
        renderer->set_occlusion({.enabled = occlusion, .price_triangles = 0});
        expect_no_allocations(scene, [&](const PinholeView& view, const DrawSet& set) {
            return bool(renderer->render_ids(view, set, buffer, stats));
        });
    }
    EXPECT_GT(stats.hidden_triangles, 0u);
    expect_no_allocations(scene, [&](const PinholeView& view, const DrawSet& set) {
        return bool(renderer->render_shaded(view, set, image, stats));
    });
#else
    GTEST_SKIP() << "the sanitizers' malloc cannot be replaced";
#endif
}

}  // namespace
}  // namespace ff::nearfield
