#pragma once

#include <memory>
#include <string>

#include "engine/core/result.h"
#include "engine/platform/input.h"

struct GLFWwindow;

namespace ff::platform {

struct WindowSettings {
    std::string title = "Farfield";
    int width = 1280;  ///< of the client area, in screen units; at least 1
    int height = 720;
    bool vsync = true;
    bool fullscreen = false;  ///< on the primary monitor, at its own resolution
};

struct FramebufferSize {
    int width = 0, height = 0;  ///< pixels; 0 while the window is minimised
};

/// A window with an OpenGL 4.5 core context, current on the thread that opened it. Use from the main thread only
/// (GLFW's rule).
class Window {
  public:
    /// Errors: no display, or no OpenGL 4.5 there; the message says which, and GLFW's own words.
    static Result<Window> open(const WindowSettings& settings);

    Window(Window&&) noexcept;
    Window& operator=(Window&&) noexcept;
    ~Window();

    /// Takes in what happened since the last poll. @return false once the user wants the window closed.
    bool poll(InputState& input);
    /// Shows what was drawn.
    void swap();

    [[nodiscard]] FramebufferSize framebuffer_size() const;
    void set_title(const std::string& title);
    /// Hides the mouse and keeps it in the window; only then does InputState have mouse_dx and mouse_dy.
    void capture_mouse(bool captured);
    [[nodiscard]] bool mouse_captured() const;

    /// For the overlay, whose back end speaks GLFW.
    [[nodiscard]] GLFWwindow* handle() const;

  private:
    struct Impl;
    explicit Window(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::platform
