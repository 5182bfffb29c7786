#pragma once
// Errors of the first kind (STYLE.md section 5): our own mistakes. On in every build; not for inner loops.

#include <fmt/core.h>

#include <string>

namespace ff {
/// Prints the broken promise and where it stands, then aborts.
[[noreturn]] void check_failed(const char* condition, const char* file, int line, const std::string& message);
}  // namespace ff

#define FF_CHECK(condition, ...)                                                          \
    do {                                                                                  \
        if (!(condition)) [[unlikely]]                                                    \
            ::ff::check_failed(#condition, __FILE__, __LINE__, fmt::format(__VA_ARGS__)); \
    } while (false)
