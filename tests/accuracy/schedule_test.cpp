#include "tools/accuracy/schedule.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace ff::accuracy {
namespace {

TEST(ScheduleTest, spreads_segments_from_the_walk_s_first_to_its_last_frame) {
    const Effort effort{.segments = 3, .warm_up_frames = 2, .counted_frames = 5};
    const auto frames = schedule(100, effort);
    ASSERT_EQ(frames.size(), 21u);
    EXPECT_EQ(frames.front().walk_frame, 0u);
    EXPECT_EQ(frames.back().walk_frame, 99u);
    EXPECT_EQ(std::count_if(frames.begin(), frames.end(), [](const auto& f) { return f.counted; }), 15);
    for (std::size_t i = 1; i < frames.size(); ++i) {
        EXPECT_EQ(frames[i].first, i % 7 == 0);
        if (frames[i].first) continue;
        EXPECT_EQ(frames[i].walk_frame, frames[i - 1].walk_frame + 1);
    }
}

TEST(ScheduleTest, short_walks_are_drawn_without_repeating_a_frame) {
    for (std::size_t length = 1; length < 60; ++length) {
        const auto frames = schedule(length, kThorough);
        ASSERT_FALSE(frames.empty());
        EXPECT_TRUE(frames.back().counted);
        for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_GT(frames[i].walk_frame, frames[i - 1].walk_frame);
        EXPECT_LT(frames.back().walk_frame, length);
    }
}

}  // namespace
}  // namespace ff::accuracy
