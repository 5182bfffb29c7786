#pragma once
// What moves of itself, to the bytes of a pack's chunk `animation` (animation.fbs) and back.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/scene/animation.h"

namespace ff::scene {

/// The same bytes for the same set.
[[nodiscard]] std::vector<std::uint8_t> animation_to_bytes(const AnimationSet& set);

/// @param bytes  at an address that is a multiple of 8
/// @param set    filled; its numbers mean something only once find_animation_problem has passed them
/// @return what is wrong with the buffer itself, "" for nothing. Takes no more memory than a few times the bytes.
[[nodiscard]] std::string animation_from_bytes(std::span<const std::uint8_t> bytes, AnimationSet& set);

}  // namespace ff::scene
