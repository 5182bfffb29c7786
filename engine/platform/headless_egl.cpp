#include <epoxy/egl.h>
#include <fmt/core.h>

#include <array>
#include <string>

#include "engine/platform/headless.h"

namespace ff::platform {

struct HeadlessContext::Impl {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() {
        if (display == EGL_NO_DISPLAY) return;
        if (context != EGL_NO_CONTEXT) {
            if (eglGetCurrentContext() == context)
                eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
            eglDestroyContext(display, context);
        }
        // The display itself is the process's, shared by all contexts: eglTerminate would pull it from under others.
    }
};

namespace {

/// What EGL says of its last failure, as a name where it is one of the common ones.
std::string egl_error_name() {
    const EGLint error = eglGetError();
    switch (error) {
        case EGL_NOT_INITIALIZED:
            return "EGL_NOT_INITIALIZED";
        case EGL_BAD_ALLOC:
            return "EGL_BAD_ALLOC";
        case EGL_BAD_MATCH:
            return "EGL_BAD_MATCH";
        case EGL_BAD_ATTRIBUTE:
            return "EGL_BAD_ATTRIBUTE";
        case EGL_BAD_PARAMETER:
            return "EGL_BAD_PARAMETER";
        default:
            return fmt::format("EGL error {:#x}", error);
    }
}

/// Makes an OpenGL 4.5 core context current on the display. Returns what went wrong, or an empty string.
std::string make_context(EGLDisplay display, EGLContext& context) {
    EGLint major = 0, minor = 0;
    if (!eglInitialize(display, &major, &minor)) return "eglInitialize: " + egl_error_name();
    if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context"))
        return "the display has no EGL_KHR_surfaceless_context";
    if (!eglBindAPI(EGL_OPENGL_API)) return "eglBindAPI(EGL_OPENGL_API): " + egl_error_name();

    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!epoxy_has_egl_extension(display, "EGL_KHR_no_config_context")) {
        const std::array<EGLint, 3> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
        EGLint count = 0;
        if (!eglChooseConfig(display, wanted.data(), &config, 1, &count) || count < 1)
            return "no EGL config for OpenGL";
    }
    const std::array<EGLint, 7> attributes{
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (context == EGL_NO_CONTEXT) return "eglCreateContext for OpenGL 4.5 core: " + egl_error_name();
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        std::string why = "eglMakeCurrent: " + egl_error_name();
        eglDestroyContext(display, context);
        context = EGL_NO_CONTEXT;
        return why;
    }
    return {};
}

}  // namespace

HeadlessContext::HeadlessContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HeadlessContext::HeadlessContext(HeadlessContext&&) noexcept = default;
HeadlessContext& HeadlessContext::operator=(HeadlessContext&&) noexcept = default;
HeadlessContext::~HeadlessContext() = default;

Result<HeadlessContext> HeadlessContext::open() {
    if (!epoxy_has_egl()) return failure("libEGL not found; install libegl1 and a driver (libgl1-mesa-dri)");
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base"))
        return failure("this EGL has no EGL_EXT_platform_base; install Mesa's EGL (libegl-mesa0)");

    auto impl = std::make_unique<Impl>();
    std::string tried;
    const auto try_display = [&](const char* name, EGLDisplay display) {
        if (display == EGL_NO_DISPLAY) {
            tried += fmt::format("\n  {}: no display", name);
            return false;
        }
        const std::string why = make_context(display, impl->context);
        if (why.empty()) {
            impl->display = display;
            return true;
        }
        tried += fmt::format("\n  {}: {}", name, why);
        return false;
    };

    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless") &&
        try_display("surfaceless",
                    eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)))
        return HeadlessContext(std::move(impl));
    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration")) {
        std::array<EGLDeviceEXT, 8> devices{};
        EGLint count = 0;
        if (!eglQueryDevicesEXT(EGLint(devices.size()), devices.data(), &count)) count = 0;
        for (EGLint i = 0; i < count; ++i) {
            if (try_display("device", eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr)))
                return HeadlessContext(std::move(impl));
        }
    }
    return failure(
        fmt::format("no headless OpenGL 4.5 core context; install libgl1-mesa-dri and libegl1, or a GPU's driver. "
                    "Tried:{}",
                    tried.empty() ? "\n  nothing: EGL offers neither surfaceless nor device platforms" : tried));
}

}  // namespace ff::platform
