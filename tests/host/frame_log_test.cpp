#include "engine/host/frame_log.h"

#include <gtest/gtest.h>

namespace ff::host {
namespace {

TEST(FrameLog, tells_quantiles_and_the_worst) {
    FrameLog log;
    for (int i = 1; i <= 1000; ++i) log.add(0.05 * i - 0.01, 640, 640);
    EXPECT_EQ(log.frames(), 1000u);
    EXPECT_NEAR(log.quantile_ms(0.5), 25.0, 0.11);
    EXPECT_NEAR(log.quantile_ms(0.99), 49.5, 0.11);
    EXPECT_NEAR(log.quantile_ms(1.0), 49.99, 1e-9);
    EXPECT_NEAR(log.worst_ms(), 49.99, 1e-9);
    EXPECT_NE(log.to_text().find("all at full size"), std::string::npos);
}

TEST(FrameLog, tells_what_was_given_up) {
    FrameLog log;
    for (int i = 0; i < 30; ++i) log.add(20.0, 640, 640);
    for (int i = 0; i < 10; ++i) log.add(20.0, i == 0 ? 320 : 538, 640);
    EXPECT_DOUBLE_EQ(log.coarser_share(), 0.25);
    EXPECT_DOUBLE_EQ(log.coarsest(), 0.5);
    EXPECT_NE(log.to_text().find("25.0% of the frames were drawn smaller, down to 50%"), std::string::npos);
}

TEST(FrameLog, a_hang_is_the_worst_and_no_crash) {
    FrameLog log;
    log.add(1e9, 640, 640);
    log.add(-1.0, 640, 640);
    EXPECT_EQ(log.worst_ms(), 1e9);
    EXPECT_EQ(log.frames(), 2u);
}

}  // namespace
}  // namespace ff::host
