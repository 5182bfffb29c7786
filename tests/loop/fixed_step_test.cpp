#include "engine/loop/fixed_step.h"

#include <gtest/gtest.h>

#include <limits>

namespace ff::loop {
namespace {

constexpr std::int64_t kMsNs = 1'000'000;

TEST(FixedStep, a_second_of_any_frames_is_as_many_ticks) {
    for (const int frames : {1, 7, 60, 144, 1000}) {
        FixedStep step({.ticks_per_second = 120, .max_ticks = 120});
        std::int64_t at = 0;
        for (int f = 1; f <= frames; ++f) {
            const std::int64_t next = 1000 * kMsNs * f / frames;
            step.advance(next - at);
            at = next;
        }
        EXPECT_EQ(step.ticks(), 120u) << frames;
    }
}

TEST(FixedStep, the_fraction_is_where_rendering_stands_between_two_ticks) {
    FixedStep step({.ticks_per_second = 100});
    EXPECT_EQ(step.advance(25 * kMsNs), 2);
    EXPECT_DOUBLE_EQ(step.fraction(), 0.5);
    EXPECT_EQ(step.advance(5 * kMsNs), 1);
    EXPECT_DOUBLE_EQ(step.fraction(), 0.0);
}

TEST(FixedStep, no_time_and_time_that_runs_backwards_is_no_tick) {
    FixedStep step({.ticks_per_second = 100});
    step.advance(5 * kMsNs);
    EXPECT_EQ(step.advance(0), 0);
    EXPECT_EQ(step.advance(-3600 * 1000 * kMsNs), 0);
    EXPECT_EQ(step.advance(std::numeric_limits<std::int64_t>::min()), 0);
    EXPECT_DOUBLE_EQ(step.fraction(), 0.5);
}

TEST(FixedStep, a_halt_is_not_caught_up) {
    FixedStep step({.ticks_per_second = 120, .max_ticks = 12});
    EXPECT_EQ(step.advance(10'000 * kMsNs), 12);
    EXPECT_EQ(step.dropped_ticks(), 1188u);
    EXPECT_EQ(step.advance(std::numeric_limits<std::int64_t>::max()), 12);
    EXPECT_EQ(step.advance(0), 0);
}

}  // namespace
}  // namespace ff::loop
