#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/core/result.h"
#include "engine/gl/object.h"

namespace ff::gl {

namespace detail {
void delete_texture(GLuint id);
}

/// A 2D texture with storage of a fixed format and size.
class Texture {
  public:
    Texture() = default;
    /// @param internal_format  sized, e.g. GL_SRGB8_ALPHA8
    /// @param levels           mips, level 0 included
    /// Errors: larger than the driver allows, or no memory.
    static Result<Texture> make(GLenum internal_format, int width, int height, int levels = 1);

    /// One level, rows tightly packed. @param format, type  as glTexSubImage2D's
    void write_level(int level, GLenum format, GLenum type, std::span<const std::byte> texels);
    void set_wrap(GLenum u, GLenum v);
    void set_filter(GLenum minify, GLenum magnify);

    [[nodiscard]] GLuint id() const { return object_.id(); }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }

  private:
    Object<detail::delete_texture> object_;
    int width_ = 0, height_ = 0;
};

}  // namespace ff::gl
