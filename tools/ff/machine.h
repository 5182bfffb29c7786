#pragma once

#include <string>

namespace ff::tool {

/// The processor's name, or "unknown".
[[nodiscard]] std::string cpu_name();

}  // namespace ff::tool
