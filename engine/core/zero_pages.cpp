#include "engine/core/zero_pages.h"

#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>

#include "engine/core/jobs.h"

namespace ff {
namespace {

constexpr std::size_t kHugePage = 2 << 20;
constexpr std::size_t kLeastMapped = 4 << 20;  // bytes; less gains nothing by huge pages

std::size_t round_up(std::size_t bytes) {
    return (bytes + kHugePage - 1) / kHugePage * kHugePage;
}

}  // namespace

void* allocate_zero_pages(std::size_t bytes) {
    if (bytes < kLeastMapped) {
        void* const memory = std::calloc(bytes, 1);
        if (memory == nullptr) throw std::bad_alloc();
        return memory;
    }
    // A huge page more than needed, to begin at the start of one; what is over goes back.
    const std::size_t size = round_up(bytes);
    void* const mapped = mmap(nullptr, size + kHugePage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) throw std::bad_alloc();
    const auto first = reinterpret_cast<std::uintptr_t>(mapped);
    const std::size_t before = round_up(first) - first, after = kHugePage - before;
    auto* const memory = static_cast<std::byte*>(mapped) + before;
    if (before > 0) munmap(mapped, before);
    if (after > 0) munmap(memory + size, after);
#ifdef MADV_HUGEPAGE
    // Only a hint: where it is refused everything works with small pages. A tile of pixels lies on sixteen rows of each
    // array, every row on a small page of its own, and misses of the address translation would be half of the time.
    madvise(memory, size, MADV_HUGEPAGE);
#endif
    return memory;
}

void populate_pages(void* memory, std::size_t bytes) {
    constexpr std::size_t kPage = 4096;
    auto* const first = static_cast<volatile std::byte*>(memory);
    parallel_ranges(bytes, kHugePage, [first](std::size_t begin, std::size_t end) {
        for (std::size_t at = begin; at < end; at += kPage) first[at] = first[at];
    });
}

void free_zero_pages(void* memory, std::size_t bytes) {
    if (bytes < kLeastMapped)
        std::free(memory);
    else
        munmap(memory, round_up(bytes));
}

}  // namespace ff
