#pragma once

#include <cstdint>

#include "engine/farfield/visibility_buffer.h"

namespace ff::farfield {

/// Depths that differ by less than this share of themselves are a tie: either primitive is right.
inline constexpr float kTieShare = 1e-4f;

/// Whether two answers for a pixel name different primitives that are no tie in depth.
[[nodiscard]] bool is_wrong_pixel(const VisibilityBuffer& answers, const VisibilityBuffer& truth, std::size_t at);

/// Pixels of an image of their size that see another primitive than the truth says, ties excepted.
[[nodiscard]] std::uint64_t count_wrong_pixels(const VisibilityBuffer& answers, const VisibilityBuffer& truth);

}  // namespace ff::farfield
