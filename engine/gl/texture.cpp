#include "engine/gl/texture.h"

#include <fmt/core.h>

#include <algorithm>

#include "engine/gl/upload_count.h"

namespace ff::gl {

void detail::delete_texture(GLuint id) {
    glDeleteTextures(1, &id);
}

Result<Texture> Texture::make(GLenum internal_format, int width, int height, int levels) {
    GLint limit = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    if (width < 1 || height < 1 || width > limit || height > limit)
        return failure(
            fmt::format("texture of {}x{} texels; the GL driver takes 1x1 to {}x{}", width, height, limit, limit));
    GLuint id = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &id);
    Texture texture;
    texture.object_ = Object<detail::delete_texture>(id);
    texture.width_ = width;
    texture.height_ = height;
    while (glGetError() != GL_NO_ERROR) {
    }
    glTextureStorage2D(id, levels, internal_format, width, height);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
        return failure(fmt::format("the GL driver makes no texture of format {:#x}, {}x{}, {} levels (error {:#x})",
                                   internal_format, width, height, levels, error));
    return texture;
}

void Texture::write_level(int level, GLenum format, GLenum type, std::span<const std::byte> texels) {
    detail::count_upload(texels.size());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage2D(id(), level, 0, 0, std::max(1, width_ >> level), std::max(1, height_ >> level), format, type,
                        texels.data());
}

void Texture::set_wrap(GLenum u, GLenum v) {
    glTextureParameteri(id(), GL_TEXTURE_WRAP_S, GLint(u));
    glTextureParameteri(id(), GL_TEXTURE_WRAP_T, GLint(v));
}

void Texture::set_filter(GLenum minify, GLenum magnify) {
    glTextureParameteri(id(), GL_TEXTURE_MIN_FILTER, GLint(minify));
    glTextureParameteri(id(), GL_TEXTURE_MAG_FILTER, GLint(magnify));
}

}  // namespace ff::gl
