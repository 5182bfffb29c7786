#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/gl/device.h"
#include "engine/platform/headless.h"
#include "engine/platform/input.h"
#include "engine/platform/output.h"
#include "engine/platform/window.h"

namespace ff::platform {
namespace {

TEST(Output, is_headless_without_a_display_unless_a_window_is_asked_for) {
    EXPECT_EQ(choose_output(OutputWish::either, "", ""), Output::headless);
    EXPECT_EQ(choose_output(OutputWish::either, ":0", ""), Output::window);
    EXPECT_EQ(choose_output(OutputWish::either, "", "wayland-0"), Output::window);
    EXPECT_EQ(choose_output(OutputWish::window, "", ""), Output::window);
    EXPECT_EQ(choose_output(OutputWish::headless, ":0", "wayland-0"), Output::headless);
}

TEST(DeadZone, holds_still_inside_grows_without_a_jump_and_reaches_full_tilt) {
    float x = 0.1f, y = 0.1f;
    apply_dead_zone(x, y);
    EXPECT_EQ(x, 0.0f);
    EXPECT_EQ(y, 0.0f);
    x = 0.1501f, y = 0.0f;
    apply_dead_zone(x, y);
    EXPECT_GT(x, 0.0f);
    EXPECT_LT(x, 0.001f);
    x = 0.8f, y = -0.8f;  // corners of a square gate reach beyond 1
    apply_dead_zone(x, y);
    EXPECT_NEAR(std::sqrt(x * x + y * y), 1.0f, 1e-5f);
    EXPECT_FLOAT_EQ(x, -y);
    x = std::numeric_limits<float>::quiet_NaN(), y = 0.0f;
    apply_dead_zone(x, y);
    EXPECT_EQ(x, 0.0f);
}

TEST(HeadlessContext, gives_opengl_4_5_without_a_display) {
    auto context = HeadlessContext::open();
    ASSERT_TRUE(context) << context.error().message;
    const auto device = gl::query_device();
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_FALSE(device->renderer.empty());
}

TEST(HeadlessContext, can_be_opened_again_after_it_was_closed) {
    for (int i = 0; i < 3; ++i) {
        auto context = HeadlessContext::open();
        ASSERT_TRUE(context) << context.error().message;
        HeadlessContext moved = std::move(*context);
        EXPECT_TRUE(gl::query_device());
    }
}

TEST(Window, of_no_size_is_a_usage_error) {
    const auto window = Window::open({.width = 0});
    ASSERT_FALSE(window);
    EXPECT_EQ(window.error().kind, ErrorKind::usage);
}

TEST(Window, says_why_there_is_none_or_opens) {
    auto window = Window::open({.width = 64, .height = 48, .vsync = false});
    if (!window) {
        EXPECT_NE(window.error().message.find("no window"), std::string::npos) << window.error().message;
        return;
    }
    InputState input;
    EXPECT_TRUE(window->poll(input));
    EXPECT_FALSE(input.held(Key::w));
    EXPECT_GT(window->framebuffer_size().width, 0);
    window->swap();
}

}  // namespace
}  // namespace ff::platform
