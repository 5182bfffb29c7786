#pragma once
// Which frames of a walk the lab draws.

#include <cstddef>
#include <vector>

namespace ff::accuracy {

/// How much is measured.
struct Effort {
    int segments = 6;         ///< pieces of the walk, evenly spread
    int warm_up_frames = 4;   ///< at the start of each, drawn but not counted: budgets settle, caches fill
    int counted_frames = 12;  ///< of each, after these
    int laps = 3;             ///< timed ones
    int pairs = 10;           ///< pairs of knobs that are tried together
};
inline constexpr Effort kThorough{};
inline constexpr Effort kQuick{.segments = 2, .warm_up_frames = 2, .counted_frames = 4, .laps = 3, .pairs = 3};

/// One frame that is drawn.
struct ScheduledFrame {
    std::size_t walk_frame = 0;
    bool counted = false;
    bool first = false;  ///< of a segment: nothing came right before it
};

/// Frames in the order in which they are drawn; a short walk has fewer or shorter segments, never overlapping ones.
/// At least one is counted where the walk has any. @param walk_frames  > 0
[[nodiscard]] std::vector<ScheduledFrame> schedule(std::size_t walk_frames, const Effort& effort);

}  // namespace ff::accuracy
