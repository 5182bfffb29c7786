#include "engine/loop/free_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace ff::loop {
namespace {

using platform::InputState;
using platform::Key;

InputState holding(Key key) {
    InputState input;
    input.keys.set(std::size_t(key));
    return input;
}

TEST(FreeCamera, w_walks_where_the_viewer_looks) {
    Camera camera{.yaw = radians_of(90.0)};  // east
    move_free_camera(holding(Key::w), 0.1, {.walk_m_s = 10.0}, camera);
    EXPECT_NEAR(camera.position.x, 1.0, 1e-12);
    EXPECT_NEAR(camera.position.z, 0.0, 1e-12);
}

TEST(FreeCamera, walks_level_however_steeply_the_viewer_looks) {
    Camera camera{.pitch = -1.2};
    move_free_camera(holding(Key::w), 0.1, {}, camera);
    EXPECT_EQ(camera.position.y, 0.0);
    EXPECT_LT(camera.position.z, -0.1);
}

TEST(FreeCamera, the_mouse_turns_right_and_down_and_stops_at_straight_down) {
    InputState input;
    input.mouse_dx = 100;
    input.mouse_dy = 1e6;
    Camera camera;
    move_free_camera(input, 0.01, {}, camera);
    EXPECT_GT(camera.yaw, 0.0);
    EXPECT_DOUBLE_EQ(camera.pitch, -0.5 * kPi);
}

TEST(FreeCamera, a_hiccup_or_a_clock_that_runs_backwards_is_not_a_leap) {
    for (const double dt : {10.0, -5.0, std::numeric_limits<double>::quiet_NaN()}) {
        Camera camera;
        move_free_camera(holding(Key::w), dt, {.walk_m_s = 1.0}, camera);
        EXPECT_LE(std::abs(camera.position.z), 0.1) << dt;
    }
}

}  // namespace
}  // namespace ff::loop
