#pragma once
// What keys, mouse and gamepad mean: from what the player does to the command that a tick gets.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"
#include "engine/loop/user_command.h"
#include "engine/platform/input.h"

namespace ff::loop {

/// A key, mouse button or gamepad button by which an action is done.
struct Trigger {
    enum class Device : std::uint8_t { none, key, mouse, gamepad };
    Device device = Device::none;
    std::uint8_t code = 0;  ///< platform::Key, platform::MouseButton, or the bit in GamepadState::buttons

    friend bool operator==(const Trigger&, const Trigger&) = default;
};

/// "w", "left shift", "mouse right", "pad a"; none: "-". parse_trigger reads what trigger_name writes.
[[nodiscard]] std::string trigger_name(const Trigger& trigger);
/// Errors (bad input): no such key; the message names the nearest that there is.
[[nodiscard]] Result<Trigger> parse_trigger(std::string_view name);
/// What the player pressed since the last poll, for a menu that asks for a new key; none where nothing was.
[[nodiscard]] Trigger pressed_trigger(const platform::InputState& input);

/// The four ways to walk come first; bit i of UserCommand::buttons is the action kWalkActions + i.
enum WalkAction : std::uint8_t { kAhead, kBack, kLeft, kRight, kWalkActions };

struct Action {
    std::string name;       ///< in settings files and menus: "ahead", "jump"
    Trigger triggers[3]{};  ///< any of them does it
};

struct LookSettings {
    double mouse_radians_px = 0.0022;  ///< of turn per pixel of mouse movement; > 0
    double stick_radians_s = 2.5;      ///< of turn per second at full tilt
    double key_radians_s = 1.5;        ///< of turn per second by the arrow keys
    bool invert_pitch = false;
};

class Controls {
  public:
    /// @param actions  the walking ones first, then at most 16
    Controls(std::vector<Action> actions, LookSettings look);

    [[nodiscard]] std::span<const Action> actions() const { return actions_; }
    [[nodiscard]] std::span<Action> actions() { return actions_; }
    [[nodiscard]] LookSettings& look() { return look_; }
    [[nodiscard]] const LookSettings& look() const { return look_; }

    [[nodiscard]] bool held(int action, const platform::InputState& input) const;

    /// Turns the view by what was done since the last call.
    /// @param dt_s        seconds since then; clamped to [0, 0.1], so that a hiccup is not a leap
    /// @param view_scale  of turning: below 1 through a spyglass
    void turn(const platform::InputState& input, double dt_s, double view_scale);
    /// The command of ticks from now on. A button that went down and up between two calls is held for one tick: call
    /// this once for every tick, with the input of the frame.
    [[nodiscard]] UserCommand command(const platform::InputState& input) const;

    /// Where the player looks, radians; set at spawn and after loading.
    void look_at(double yaw, double pitch);
    [[nodiscard]] double yaw() const { return yaw_; }
    [[nodiscard]] double pitch() const { return pitch_; }

  private:
    std::vector<Action> actions_;
    LookSettings look_;
    double yaw_ = 0.0, pitch_ = 0.0;
};

}  // namespace ff::loop
