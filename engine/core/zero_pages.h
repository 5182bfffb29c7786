#pragma once
// Arrays whose memory comes zeroed from the system, page by page as it is first touched: making one costs microseconds
// however large it is, and what is never used of it takes no memory.

#include <cstddef>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace ff {

/// Zeroed memory, in huge pages where it is large and the system has them. Throws std::bad_alloc.
[[nodiscard]] void* allocate_zero_pages(std::size_t bytes);
/// @param bytes  as they were allocated
void free_zero_pages(void* memory, std::size_t bytes);

/// Makes the system give memory its pages now, where it would do so at first touch: in frames, a page here and there
/// costs more than a frame has. Keeps what the memory holds.
void populate_pages(void* memory, std::size_t bytes);

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
        if (count > std::numeric_limits<std::size_t>::max() / 2 / sizeof(T)) throw std::bad_array_new_length();
        return static_cast<T*>(allocate_zero_pages(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) { free_zero_pages(memory, count * sizeof(T)); }
    template <class U>
    void construct(U*) {}
    template <class U, class... Values>
    void construct(U* at, Values&&... values) {
        ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
    }
    friend bool operator==(const ZeroPages&, const ZeroPages&) { return true; }
};

template <class T>
using ZeroPageVector = std::vector<T, ZeroPages<T>>;

template <class T>
void populate_pages(ZeroPageVector<T>& values) {
    populate_pages(values.data(), values.size() * sizeof(T));
}

}  // namespace ff
