#include "engine/gl/device.h"

#include <epoxy/gl.h>
#include <fmt/core.h>

#include <atomic>

#include "engine/core/log.h"

namespace ff::gl {
namespace {

std::string text_of(GLenum name) {
    const GLubyte* text = glGetString(name);
    return text ? reinterpret_cast<const char*>(text) : "";
}

std::atomic<int> error_count{0};

void APIENTRY on_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei, const GLchar* message, const void*) {
    if (severity == GL_DEBUG_SEVERITY_NOTIFICATION || type == GL_DEBUG_TYPE_OTHER) return;
    if (type == GL_DEBUG_TYPE_ERROR) ++error_count;
    log_warning("OpenGL: {}", message);
}

}  // namespace

Result<DeviceInfo> query_device() {
    DeviceInfo info{.vendor = text_of(GL_VENDOR), .renderer = text_of(GL_RENDERER), .version = text_of(GL_VERSION)};
    if (info.version.empty()) return failure("no OpenGL context is current");
    if (epoxy_gl_version() < 45)
        return failure(fmt::format("OpenGL {} ({}); expected 4.5 or newer", info.version, info.renderer));
    for (const char* software : {"llvmpipe", "softpipe", "SwiftShader"})
        info.is_software = info.is_software || info.renderer.find(software) != std::string::npos;
    return info;
}

void enable_debug_output() {
    error_count = 0;
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(on_message, nullptr);
}

int debug_error_count() {
    return error_count;
}

}  // namespace ff::gl
