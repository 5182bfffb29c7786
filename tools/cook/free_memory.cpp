#include "tools/cook/free_memory.h"

#include <malloc.h>

namespace ff::cook {
namespace {

constexpr std::uint64_t kPortion = 192ull << 20;  // a call walks the whole heap: some 10 ms

}  // namespace

void FreedMemory::add(std::uint64_t bytes) {
    const std::uint64_t before = pending_.fetch_add(bytes);
    if (before / kPortion != (before + bytes) / kPortion) malloc_trim(0);
}

}  // namespace ff::cook
