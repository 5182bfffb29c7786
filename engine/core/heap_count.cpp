#include "engine/core/heap_count.h"

namespace ff {
namespace {
// Of the process, as malloc is.
std::uint64_t (*g_counter)() = nullptr;
}  // namespace

std::uint64_t heap_allocation_count() {
    return g_counter == nullptr ? 0 : g_counter();
}

void set_heap_counter(std::uint64_t (*counter)()) {
    g_counter = counter;
}

}  // namespace ff
