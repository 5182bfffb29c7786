// Steady frames of moving models allocate nothing: whatever of them comes into view, in whatever pose.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "engine/animation/dynamic_models.h"
#include "engine/frame/dynamic_overlay.h"
#include "tests/support/animated_worlds.h"

namespace {
std::atomic<std::uint64_t> g_allocations{0};
}

[[gnu::noinline]] void* operator new(std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    if (void* memory = std::malloc(size)) return memory;
    std::abort();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

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

}  // namespace
}  // namespace ff::animation
