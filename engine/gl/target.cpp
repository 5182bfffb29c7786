#include "engine/gl/target.h"

#include <fmt/core.h>

namespace ff::gl {

void detail::delete_framebuffer(GLuint id) {
    glDeleteFramebuffers(1, &id);
}

Result<Target> Target::make(GLenum color_format, int width, int height) {
    Target target;
    FF_ASSIGN(target.color_, Texture::make(color_format, width, height));
    FF_ASSIGN(target.depth_, Texture::make(GL_DEPTH_COMPONENT32F, width, height));
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    target.framebuffer_ = Object<detail::delete_framebuffer>(id);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, target.color_.id(), 0);
    glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, target.depth_.id(), 0);
    const GLenum status = glCheckNamedFramebufferStatus(id, GL_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE)
        return failure(
            fmt::format("the GL driver does not draw into format {:#x} (status {:#x})", color_format, status));
    return target;
}

}  // namespace ff::gl
