#pragma once

#include "engine/core/result.h"
#include "engine/gl/texture.h"

namespace ff::gl {

namespace detail {
void delete_framebuffer(GLuint id);
}

/// Textures to draw into: one colour, and a 32-bit float depth.
class Target {
  public:
    Target() = default;
    /// Errors: the driver does not draw into this format.
    static Result<Target> make(GLenum color_format, int width, int height);

    [[nodiscard]] GLuint id() const { return framebuffer_.id(); }
    [[nodiscard]] const Texture& color() const { return color_; }
    [[nodiscard]] const Texture& depth() const { return depth_; }
    [[nodiscard]] int width() const { return color_.width(); }
    [[nodiscard]] int height() const { return color_.height(); }

  private:
    Object<detail::delete_framebuffer> framebuffer_;
    Texture color_, depth_;
};

}  // namespace ff::gl
