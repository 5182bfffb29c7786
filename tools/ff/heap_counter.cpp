#include "tools/ff/heap_counter.h"

#include <atomic>
#include <cerrno>
#include <cstddef>

#include "engine/core/sanitizers.h"

namespace {
std::atomic<std::uint64_t> g_allocations{0};
}

namespace ff::tool {
std::uint64_t heap_allocations() {
    return g_allocations.load(std::memory_order_relaxed);
}
}  // namespace ff::tool

#if defined(__GLIBC__) && !defined(FF_SANITIZES_MEMORY)
// glibc's documented way to replace malloc: define the family in the executable and forward to the originals.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
    g_allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
    void* memory = memalign(alignment, size);
    if (memory == nullptr) return ENOMEM;
    *out = memory;
    return 0;
}
}
#endif
