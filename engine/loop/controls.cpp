#include "engine/loop/controls.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/check.h"
#include "engine/math/types.h"

namespace ff::loop {
namespace {

using platform::InputState;
using platform::Key;
using platform::MouseButton;

constexpr auto kKeyNames = std::to_array<std::string_view>({"a",
                                                            "b",
                                                            "c",
                                                            "d",
                                                            "e",
                                                            "f",
                                                            "g",
                                                            "h",
                                                            "i",
                                                            "j",
                                                            "k",
                                                            "l",
                                                            "m",
                                                            "n",
                                                            "o",
                                                            "p",
                                                            "q",
                                                            "r",
                                                            "s",
                                                            "t",
                                                            "u",
                                                            "v",
                                                            "w",
                                                            "x",
                                                            "y",
                                                            "z",
                                                            "0",
                                                            "1",
                                                            "2",
                                                            "3",
                                                            "4",
                                                            "5",
                                                            "6",
                                                            "7",
                                                            "8",
                                                            "9",
                                                            "space",
                                                            "enter",
                                                            "escape",
                                                            "tab",
                                                            "backspace",
                                                            "page up",
                                                            "page down",
                                                            "up",
                                                            "down",
                                                            "left",
                                                            "right",
                                                            "left shift",
                                                            "right shift",
                                                            "left control",
                                                            "right control",
                                                            "left alt",
                                                            "right alt",
                                                            "f1",
                                                            "f2",
                                                            "f3",
                                                            "f4",
                                                            "f5",
                                                            "f6",
                                                            "f7",
                                                            "f8",
                                                            "f9",
                                                            "f10",
                                                            "f11",
                                                            "f12"});
static_assert(kKeyNames.size() == std::size_t(Key::count));
constexpr std::array<std::string_view, 3> kMouseNames{"mouse left", "mouse right", "mouse middle"};
static_assert(kMouseNames.size() == std::size_t(MouseButton::count));
constexpr auto kPadNames = std::to_array<std::string_view>(
    {"pad a", "pad b", "pad x", "pad y", "pad left bumper", "pad right bumper", "pad back", "pad start", "pad guide",
     "pad left thumb", "pad right thumb", "pad up", "pad right", "pad down", "pad left"});

struct Names {
    Trigger::Device device;
    std::span<const std::string_view> names;
};
const std::array<Names, 3> kNames{Names{Trigger::Device::key, kKeyNames}, Names{Trigger::Device::mouse, kMouseNames},
                                  Names{Trigger::Device::gamepad, kPadNames}};

/// Letters to change, add or drop to make one of the other.
std::size_t distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t above = row[j];
            row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1] ? 1u : 0u)});
            diagonal = above;
        }
    }
    return row[b.size()];
}

bool held_now(const Trigger& trigger, const InputState& input) {
    switch (trigger.device) {
        case Trigger::Device::none:
            return false;
        case Trigger::Device::key:
            return input.keys[trigger.code] || input.keys_pressed[trigger.code];
        case Trigger::Device::mouse:
            return input.mouse_buttons[trigger.code];
        case Trigger::Device::gamepad:
            return ((input.gamepad.buttons >> trigger.code) & 1) != 0;
    }
    return false;
}

std::int8_t share_of_full(double value) {
    return std::int8_t(std::lround(std::clamp(value, -1.0, 1.0) * UserCommand::kFull));
}

}  // namespace

std::string trigger_name(const Trigger& trigger) {
    for (const Names& names : kNames)
        if (names.device == trigger.device && trigger.code < names.names.size())
            return std::string(names.names[trigger.code]);
    return "-";
}

Result<Trigger> parse_trigger(std::string_view name) {
    if (name == "-") return Trigger{};
    std::string_view nearest;
    std::size_t least = SIZE_MAX;
    for (const Names& names : kNames)
        for (std::size_t i = 0; i < names.names.size(); ++i) {
            if (names.names[i] == name) return Trigger{names.device, std::uint8_t(i)};
            if (const std::size_t d = distance(name, names.names[i]); d < least) least = d, nearest = names.names[i];
        }
    return bad_input(fmt::format("there is no key '{}'; the nearest is '{}'", name, nearest));
}

Trigger pressed_trigger(const InputState& input) {
    for (std::size_t i = 0; i < std::size_t(Key::count); ++i)
        if (input.keys_pressed[i]) return {Trigger::Device::key, std::uint8_t(i)};
    for (std::size_t i = 0; i < std::size_t(MouseButton::count); ++i)
        if (input.mouse_buttons[i]) return {Trigger::Device::mouse, std::uint8_t(i)};
    for (std::size_t i = 0; i < kPadNames.size(); ++i)
        if (((input.gamepad.buttons >> i) & 1) != 0) return {Trigger::Device::gamepad, std::uint8_t(i)};
    return {};
}

Controls::Controls(std::vector<Action> actions, LookSettings look) : actions_(std::move(actions)), look_(look) {
    FF_CHECK(actions_.size() >= kWalkActions && actions_.size() <= kWalkActions + 16, "{} actions; {} to {}",
             actions_.size(), int(kWalkActions), kWalkActions + 16);
}

bool Controls::held(int action, const InputState& input) const {
    const Action& a = actions_[std::size_t(action)];
    return std::any_of(std::begin(a.triggers), std::end(a.triggers),
                       [&](const Trigger& trigger) { return held_now(trigger, input); });
}

void Controls::turn(const InputState& input, double dt_s, double view_scale) {
    const double dt = std::clamp(std::isfinite(dt_s) ? dt_s : 0.0, 0.0, 0.1);
    const auto axis = [&](Key positive, Key negative) {
        return double(input.held(positive)) - double(input.held(negative));
    };
    const double right =
        look_.mouse_radians_px * input.mouse_dx + dt * (look_.key_radians_s * axis(Key::right, Key::left) +
                                                        look_.stick_radians_s * double(input.gamepad.right_x));
    const double down =
        look_.mouse_radians_px * input.mouse_dy +
        dt * (look_.key_radians_s * axis(Key::down, Key::up) + look_.stick_radians_s * double(input.gamepad.right_y));
    look_at(yaw_ + view_scale * right, pitch_ - view_scale * (look_.invert_pitch ? -down : down));
}

UserCommand Controls::command(const InputState& input) const {
    const auto axis = [&](WalkAction positive, WalkAction negative) {
        return double(held(positive, input)) - double(held(negative, input));
    };
    UserCommand command;
    command.move_right = share_of_full(axis(kRight, kLeft) + double(input.gamepad.left_x));
    command.move_ahead = share_of_full(axis(kAhead, kBack) - double(input.gamepad.left_y));
    command.yaw_urad = std::int32_t(std::lround(yaw_ * 1e6));
    command.pitch_urad = std::int32_t(std::lround(pitch_ * 1e6));
    for (std::size_t i = kWalkActions; i < actions_.size(); ++i)
        if (held(int(i), input)) command.buttons = std::uint16_t(command.buttons | (1u << (i - kWalkActions)));
    return command;
}

void Controls::look_at(double yaw, double pitch) {
    yaw_ = std::remainder(yaw, 2.0 * kPi);
    pitch_ = std::clamp(pitch, -0.5 * kPi, 0.5 * kPi);
}

}  // namespace ff::loop
