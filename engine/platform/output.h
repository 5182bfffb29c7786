#pragma once

#include <string_view>

namespace ff::platform {

enum class Output { window, headless };

enum class OutputWish { either, window, headless };

/// Where a run draws: a window where a display is named and nobody asked for headless. A wish for a window is granted
/// even without a display, so that opening it can say what is missing.
/// @param display          the environment's DISPLAY, empty where there is none
/// @param wayland_display  likewise WAYLAND_DISPLAY
[[nodiscard]] constexpr Output choose_output(OutputWish wish, std::string_view display,
                                             std::string_view wayland_display) {
    if (wish != OutputWish::either) return wish == OutputWish::window ? Output::window : Output::headless;
    return display.empty() && wayland_display.empty() ? Output::headless : Output::window;
}

}  // namespace ff::platform
