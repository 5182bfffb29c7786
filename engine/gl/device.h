#pragma once

#include <string>

#include "engine/core/result.h"

namespace ff::gl {

/// What the current context is and can do.
struct DeviceInfo {
    std::string vendor, renderer, version;
    bool is_software = false;  ///< llvmpipe and the like: frames cost the CPU's time
};

/// Reads the current context. Errors: none current, or older than OpenGL 4.5.
Result<DeviceInfo> query_device();

/// Sends the driver's errors and warnings to the log. Costs time: for development and tests.
void enable_debug_output();

/// Number of error messages that the driver gave since enable_debug_output.
[[nodiscard]] int debug_error_count();

}  // namespace ff::gl
