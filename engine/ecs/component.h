#pragma once
// What the storage knows of a component type: an id, a size, and how to move and destroy it. No RTTI.

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>

namespace ff::ecs {

/// Names a type within this process. Ids are given in the order of first use, so nothing that is stored or compared
/// between runs may depend on them.
using TypeId = std::uint32_t;
inline constexpr TypeId kMaxTypes = 256;  ///< components, resources and events of a process together

using TypeSet = std::bitset<kMaxTypes>;

struct ComponentInfo {
    TypeId id = 0;
    std::uint32_t size = 0;
    std::uint32_t alignment = 1;
    /// Moves a component to raw memory and ends the old one's life. Null: copying the bytes does it.
    void (*relocate)(void* to, void* from) = nullptr;
    /// Null: nothing to do.
    void (*destroy)(void* component) = nullptr;
};

namespace detail {
TypeId next_type_id();
}

template <class T>
TypeId type_id() {
    static_assert(std::is_same_v<T, std::remove_cvref_t<T>>);
    static const TypeId id = detail::next_type_id();
    return id;
}

template <class T>
const ComponentInfo& component_info() {
    static_assert(std::is_nothrow_move_constructible_v<T> && std::is_nothrow_destructible_v<T>,
                  "components move between chunks and must not throw while they do");
    static_assert(alignof(T) <= 64, "chunks are aligned to 64 bytes");
    static const ComponentInfo info = [] {
        ComponentInfo made{type_id<T>(), std::is_empty_v<T> ? 0u : std::uint32_t(sizeof(T)), std::uint32_t(alignof(T)),
                           nullptr, nullptr};
        if constexpr (!std::is_trivially_copyable_v<T>)
            made.relocate = [](void* to, void* from) {
                T* const old = static_cast<T*>(from);
                new (to) T(std::move(*old));
                old->~T();
            };
        if constexpr (!std::is_trivially_destructible_v<T>)
            made.destroy = [](void* component) { static_cast<T*>(component)->~T(); };
        return made;
    }();
    return info;
}

}  // namespace ff::ecs
