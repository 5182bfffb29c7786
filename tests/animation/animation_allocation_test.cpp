// Steady frames of moving models allocate nothing: whatever of them comes into view, in whatever pose.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "engine/animation/dynamic_models.h"
#include "engine/core/sanitizers.h"
#include "engine/frame/dynamic_overlay.h"
#include "engine/frame/renderer.h"
#include "tests/support/animated_worlds.h"

namespace {
std::atomic<std::uint64_t> g_allocations{0};
}

// Sanitizers have an allocator of their own.
#if !defined(FF_SANITIZES_MEMORY)
constexpr bool kCounts = true;
void* operator new(std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    if (void* memory = std::malloc(size)) return memory;
    std::abort();
}
// Not inlined: else the compiler sees memory of our operator new go to free(), and warns.
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
#else
constexpr bool kCounts = false;
#endif

namespace ff::animation {
namespace {

constexpr int kWidth = 160, kHeight = 128;  // whole tiles

std::vector<farfield::TileRequest> all_tiles() {
    std::vector<farfield::TileRequest> tiles;
    for (int y = 0; y < kHeight; y += farfield::kTileSize)
        for (int x = 0; x < kWidth; x += farfield::kTileSize) {
            farfield::TileRequest tile{.x = std::uint16_t(x), .y = std::uint16_t(y)};
            std::fill(std::begin(tile.rows), std::end(tile.rows), std::uint16_t(0xFFFF));
            tiles.push_back(tile);
        }
    return tiles;
}

TEST(AnimationAllocations, turning_round_among_models_allocates_nothing) {
    if (!kCounts) GTEST_SKIP() << "a sanitizer counts allocations its own way";
    const auto world = test::make_animated_world({.worms = 30, .carts = 10});
    DynamicModels models(*world);
    frame::DynamicOverlay overlay(world->scene());
    auto states = initial_models(world->info().animation);
    const auto tiles = all_tiles();
    farfield::VisibilityBuffer visibility;
    visibility.resize(kWidth, kHeight);
    farfield::PixelMask covered;
    covered.reset(kWidth, kHeight);
    const auto draw = [&](double yaw, double time_s) {
        set_time(world->info().animation, time_s, states);
        const PinholeView view = make_view({.position = {0.5, 2.0, 6.0}, .yaw = yaw}, kWidth, kHeight);
        const auto dynamic = models.pose(states, view);
        overlay.draw(view, dynamic, tiles, visibility, covered);
        return dynamic.size();
    };
    ASSERT_GT(draw(0.0, 0.0), 10u);
    // Where most is seen buffers that follow what is seen are as large as they get.
    for (int f = 0; f < 64; ++f) draw(0.1 * f, 0.01 * f);
    const std::uint64_t before = g_allocations;
    for (int f = 0; f < 64; ++f) draw(0.1 * f, 1.0 + 0.013 * f);
    EXPECT_EQ(g_allocations - before, 0u);
}

TEST(AnimationAllocations, frames_with_moving_shadows_allocate_nothing) {
    if (!kCounts) GTEST_SKIP() << "a sanitizer counts allocations its own way";
    const auto world = test::make_animated_world({.worms = 30, .carts = 10});
    for (const frame::Mode mode : {frame::Mode::hybrid, frame::Mode::beam_reuse}) {
        DynamicModels models(*world);
        frame::Casters casters(world->scene());
        frame::Renderer renderer(world->scene(), casters, nullptr, kWidth, kHeight);
        auto states = initial_models(world->info().animation);
        shading::Image image;
        const frame::FrameSettings settings{.mode = mode, .sun_shadows = frame::SunShadows::on};
        std::uint64_t sun_rays = 0;
        const auto draw = [&](double yaw, double time_s) {
            set_time(world->info().animation, time_s, states);
            const Camera camera{.position = {0.5, 2.0, 6.0}, .yaw = yaw};
            const auto dynamic = models.pose(states, make_view(camera, kWidth, kHeight));
            const frame::FrameStats& stats = renderer.draw(camera, dynamic, settings, image);
            sun_rays += stats.sun_rays;
        };
        for (int f = 0; f < 128; ++f) draw(0.1 * f, 0.013 * f);
        const std::uint64_t before = g_allocations;
        sun_rays = 0;
        for (int f = 0; f < 64; ++f) draw(0.1 * f, 1.0 + 0.013 * f);
        EXPECT_EQ(g_allocations - before, 0u) << int(mode);
        EXPECT_GT(sun_rays, 0u);
    }
}

}  // namespace
}  // namespace ff::animation
