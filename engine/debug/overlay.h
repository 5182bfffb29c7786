#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"

namespace ff::platform {
class Window;
}

namespace ff::debug {

/// What the overlay shows: text and numbers, whoever made them.
struct OverlayData {
    struct Row {
        std::string name, value;
    };
    std::string title;
    std::vector<Row> rows;
    std::span<const float> graph;  ///< oldest first, milliseconds
    float graph_budget_ms = 0.0f;  ///< the graph's top is twice this; 0: its own maximum
};

/// A table and a graph over the window's picture. One at a time. Threads: the window's.
class Overlay {
  public:
    /// The window's OpenGL context must be current. Errors: the driver refuses the overlay's shaders.
    static Result<Overlay> make(const platform::Window& window);

    Overlay(Overlay&&) noexcept;
    Overlay& operator=(Overlay&&) noexcept;
    ~Overlay();

    /// Draws over the default framebuffer; after the picture, before Window::swap.
    void draw(const OverlayData& data);
    /// The mouse or keyboard is the overlay's now: the game should leave it alone.
    [[nodiscard]] bool wants_mouse() const;
    [[nodiscard]] bool wants_keyboard() const;

  private:
    struct Impl;
    explicit Overlay(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::debug
