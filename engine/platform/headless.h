#pragma once

#include <memory>

#include "engine/core/result.h"

namespace ff::platform {

/// An OpenGL 4.5 core context without window or display, through EGL: Mesa's surfaceless platform, else the first EGL
/// device that will do. Draw into targets of your own (gl/target.h); there is no default framebuffer.
/// Threads: current on the thread that opened it until it is destroyed.
class HeadlessContext {
  public:
    /// Opens the context and makes it current. Errors: no EGL, or no device that gives OpenGL 4.5.
    static Result<HeadlessContext> open();

    HeadlessContext(HeadlessContext&&) noexcept;
    HeadlessContext& operator=(HeadlessContext&&) noexcept;
    ~HeadlessContext();

  private:
    struct Impl;
    explicit HeadlessContext(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::platform
