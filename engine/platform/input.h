#pragma once
// What the player does, as plain data: filled by Window::poll once a frame, read by the game, written by tests.

#include <bitset>
#include <cstdint>

namespace ff::platform {

// clang-format off
enum class Key : std::uint8_t {
    a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w, x, y, z,
    digit_0, digit_1, digit_2, digit_3, digit_4, digit_5, digit_6, digit_7, digit_8, digit_9,
    space, enter, escape, tab, backspace, page_up, page_down,
    up, down, left, right,
    left_shift, right_shift, left_control, right_control, left_alt, right_alt,
    f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12,
    count
};
// clang-format on

enum class MouseButton : std::uint8_t { left, right, middle, count };

/// One gamepad in the usual layout. Sticks in [-1, 1], x right, y DOWN; triggers in [0, 1]; inside the dead zone 0.
struct GamepadState {
    bool connected = false;
    float left_x = 0, left_y = 0;
    float right_x = 0, right_y = 0;
    float left_trigger = 0, right_trigger = 0;
    std::uint16_t buttons = 0;  ///< bit i: GLFW_GAMEPAD_BUTTON i (0 A, 1 B, 2 X, 3 Y, 4 and 5 bumpers, 6 back, 7 start)
};

struct InputState {
    std::bitset<std::size_t(Key::count)> keys;          ///< held now
    std::bitset<std::size_t(Key::count)> keys_pressed;  ///< went down since the last poll, even if up again by now
    std::bitset<std::size_t(MouseButton::count)> mouse_buttons;
    double mouse_x = 0, mouse_y = 0;    ///< pixels from the window's top left; meaningless while the mouse is captured
    double mouse_dx = 0, mouse_dy = 0;  ///< moved since the last poll, pixels, y down; 0 unless the mouse is captured
    double scroll = 0;                  ///< notches since the last poll, positive away from the user
    GamepadState gamepad;

    [[nodiscard]] bool held(Key key) const { return keys[std::size_t(key)]; }
    [[nodiscard]] bool pressed(Key key) const { return keys_pressed[std::size_t(key)]; }
    [[nodiscard]] bool held(MouseButton button) const { return mouse_buttons[std::size_t(button)]; }
};

/// A stick's position with its dead zone taken out: 0 inside, growing from 0 at its rim to 1 at full tilt, so that
/// there is no jump. The direction stays. @param dead_zone  [0, 1)
void apply_dead_zone(float& x, float& y, float dead_zone = 0.15f);

}  // namespace ff::platform
