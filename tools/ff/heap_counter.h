#pragma once

#include <cstdint>

namespace ff::tool {

/// Heap allocations of the process so far, on all threads: every malloc, calloc, realloc and aligned allocation, so
/// operator new and the libraries' own count too. Always 0 in sanitizer builds, whose own allocator stands in the
/// place.
[[nodiscard]] std::uint64_t heap_allocations();

}  // namespace ff::tool
