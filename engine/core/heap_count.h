#pragma once

#include <cstdint>

namespace ff {

/// Heap allocations of the process so far, on all threads; 0 where nobody counts them.
[[nodiscard]] std::uint64_t heap_allocation_count();

/// Names who counts: an executable that replaces malloc does. Call it before other threads run.
void set_heap_counter(std::uint64_t (*counter)());

}  // namespace ff
