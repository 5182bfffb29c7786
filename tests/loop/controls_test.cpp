#include "engine/loop/controls.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/math/types.h"

namespace ff::loop {
namespace {

using platform::InputState;
using platform::Key;

enum Button : int { kJump, kUse };

Controls make_controls() {
    const auto key = [](const char* name) { return *parse_trigger(name); };
    return {{{"ahead", {key("w")}},
             {"back", {key("s")}},
             {"left", {key("a")}},
             {"right", {key("d")}},
             {"jump", {key("space"), key("pad a")}},
             {"use", {key("e"), key("mouse right")}}},
            {}};
}

void press(InputState& input, Key key) {
    input.keys.set(std::size_t(key));
}

TEST(ControlsTest, names_of_triggers_are_read_back) {
    int count = 0;
    for (const auto device : {Trigger::Device::key, Trigger::Device::mouse, Trigger::Device::gamepad})
        for (std::uint8_t code = 0; code < 80; ++code) {
            const Trigger trigger{device, code};
            if (trigger_name(trigger) == "-") continue;
            ASSERT_TRUE(parse_trigger(trigger_name(trigger)));
            EXPECT_EQ(*parse_trigger(trigger_name(trigger)), trigger);
            ++count;
        }
    EXPECT_EQ(count, int(Key::count) + 3 + 15);
    EXPECT_EQ(*parse_trigger("-"), Trigger{});
    EXPECT_NE(parse_trigger("spcae").error().message.find("nearest is 'space'"), std::string::npos);
}

TEST(ControlsTest, keys_sticks_and_buttons_become_a_command) {
    const Controls controls = make_controls();
    InputState input;
    EXPECT_EQ(controls.command(input), UserCommand{});
    press(input, Key::w);
    press(input, Key::a);
    press(input, Key::space);
    UserCommand command = controls.command(input);
    EXPECT_EQ(command.move_ahead, UserCommand::kFull);
    EXPECT_EQ(command.move_right, -UserCommand::kFull);
    EXPECT_TRUE(command.held(kJump));
    EXPECT_FALSE(command.held(kUse));

    input = {};
    input.gamepad.left_x = 0.5f;
    input.gamepad.left_y = 1.0f;
    input.gamepad.buttons = 1;
    input.mouse_buttons.set(std::size_t(platform::MouseButton::right));
    command = controls.command(input);
    EXPECT_EQ(command.move_right, 64);
    EXPECT_EQ(command.move_ahead, -UserCommand::kFull);
    EXPECT_TRUE(command.held(kJump));
    EXPECT_TRUE(command.held(kUse));
}

TEST(ControlsTest, a_key_that_went_up_again_still_counts) {
    const Controls controls = make_controls();
    InputState input;
    input.keys_pressed.set(std::size_t(Key::e));
    EXPECT_TRUE(controls.command(input).held(kUse));
}

TEST(ControlsTest, looking_stays_within_straight_up_and_down_and_a_turn) {
    Controls controls = make_controls();
    InputState input;
    input.mouse_dx = 1e6;
    input.mouse_dy = 1e6;
    controls.turn(input, 0.01, 1.0);
    EXPECT_LE(std::fabs(controls.yaw()), kPi);
    EXPECT_DOUBLE_EQ(controls.pitch(), -0.5 * kPi);
    controls.look_at(0, 0);
    input.mouse_dx = 100;
    input.mouse_dy = 0;
    controls.turn(input, 0.01, 0.25);
    EXPECT_NEAR(controls.yaw(), 0.25 * 100 * controls.look().mouse_radians_px, 1e-12);
    controls.look().invert_pitch = true;
    input.mouse_dy = 100;
    controls.turn(input, 0.01, 1.0);
    EXPECT_GT(controls.pitch(), 0);
}

}  // namespace
}  // namespace ff::loop
