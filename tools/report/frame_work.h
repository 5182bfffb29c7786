#pragma once
// The exact work of a frame, as budgets limit it and reports draw it.

#include <array>

#include "engine/budget/budget_file.h"
#include "engine/frame/stats.h"

namespace ff::report {

/// By budget::kWorkKeys.
using FrameWork = std::array<std::uint64_t, budget::kWorkKeys.size()>;
inline constexpr std::size_t kAllocations = 6;  ///< its place among them

/// @param allocations   on the heap while the frame was posed and drawn
/// @param upload_bytes  to OpenGL, likewise
[[nodiscard]] FrameWork work_of(const frame::FrameStats& stats, std::uint64_t allocations, std::uint64_t upload_bytes);

/// The names of the effects, by id.
[[nodiscard]] std::span<const std::string_view> effect_names();

}  // namespace ff::report
