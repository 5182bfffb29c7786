#pragma once

#include <compare>
#include <cstdint>

namespace ff::ecs {

/// A handle: index of a slot, and which of its successive inhabitants is meant. A default one is null and never alive;
/// one that was destroyed stays dead for ever.
struct Entity {
    std::uint32_t index = 0;
    std::uint32_t generation = 0;  ///< from 1; 0 is null

    explicit operator bool() const { return generation != 0; }
    friend auto operator<=>(const Entity&, const Entity&) = default;
};

}  // namespace ff::ecs
