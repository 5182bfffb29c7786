#pragma once
// Everything that is written over the picture of a game: its own lines and bars, and the host's menus.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/host/game.h"
#include "engine/host/player_settings.h"
#include "engine/platform/input.h"

namespace ff::platform {
class Window;
}

namespace ff::host {

enum class Menu : std::uint8_t { none, title, pause, settings, end };

/// What the player chose in a menu this frame.
enum class Choice : std::uint8_t { none, start, go_on, load, save, settings, back, to_title, quit };

/// What a menu shows.
struct MenuText {
    std::string title, text;  ///< of the title and end screens
    std::string notice;       ///< "saved", or why not
    bool can_load = false;    ///< there is a saved game
};

/// Draws with Dear ImGui over the window's default framebuffer. One at a time, and beside no debug::Overlay. Threads:
/// the window's.
class Screen {
  public:
    /// The window's OpenGL context must be current. Errors: the driver refuses the shaders.
    static Result<Screen> make(const platform::Window& window);
    Screen(Screen&&) noexcept;
    Screen& operator=(Screen&&) noexcept;
    ~Screen();

    /// Draws the game's items and, if any, a menu; after the picture, before Window::swap. Menus go by mouse, arrow
    /// keys and gamepad.
    /// @param input     of the frame: a settings menu that waits for a new key takes it from there
    /// @param settings  changed by the settings menu
    /// @param rows      of the overlay, name and value; empty: none is shown
    Choice draw(std::span<const HudItem> hud, Menu menu, const MenuText& text, const platform::InputState& input,
                PlayerSettings& settings, std::span<const std::pair<std::string, std::string>> rows);

  private:
    struct Impl;
    explicit Screen(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::host
