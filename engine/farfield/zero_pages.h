#pragma once
// Arrays whose memory comes zeroed from the system, page by page as it is first touched: making one costs microseconds
// however large it is, and what is never used of it takes no memory.

#include <sys/mman.h>

#include <cstdlib>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace ff::farfield {

/// For vectors of numbers. An element made without a value is left as the memory is: zero in a vector that has just
/// been made, anything in one that shrank and grew again.
template <class T>
struct ZeroPages {
    static_assert(std::is_trivial_v<T>);
    using value_type = T;
    using is_always_equal = std::true_type;

    ZeroPages() = default;
    template <class U>
    ZeroPages(const ZeroPages<U>&) {}

    [[nodiscard]] T* allocate(std::size_t count) {
        if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_array_new_length();
        const std::size_t bytes = count * sizeof(T);
        if (bytes < kLeastMapped) {
            void* const memory = std::calloc(count, sizeof(T));
            if (memory == nullptr) throw std::bad_alloc();
            return static_cast<T*>(memory);
        }
        void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
        // Only a hint: where it is refused everything works with small pages, and misses of the address translation
        // are half of what a walk through a large image costs.
        madvise(memory, bytes, MADV_HUGEPAGE);
#endif
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t count) {
        if (count * sizeof(T) < kLeastMapped)
            std::free(memory);
        else
            munmap(memory, count * sizeof(T));
    }
    template <class U>
    void construct(U*) {}
    template <class U, class... Values>
    void construct(U* at, Values&&... values) {
        ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
    }
    friend bool operator==(const ZeroPages&, const ZeroPages&) {
        return true;
    }

  private:
    static constexpr std::size_t kLeastMapped = 4 << 20;  ///< bytes: two huge pages
};

template <class T>
using ZeroPageVector = std::vector<T, ZeroPages<T>>;

}  // namespace ff::farfield
