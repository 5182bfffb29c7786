#pragma once
// The time that frames, passes and effects are measured in.

#include <chrono>
#include <cstdint>

namespace ff {

/// Now, on a clock that only goes forward; nanoseconds since a moment that nobody knows. Profiling only, as Stopwatch.
[[nodiscard]] inline std::int64_t steady_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

enum class WorkClock : std::uint8_t {
    wall,  ///< what users wait for
    /// What the calling thread has run: without the time in which other processes had its core. The whole of a frame
    /// only where one worker draws it.
    thread,
};

/// Chooses for the whole process; wall at first. Call it between frames.
void set_work_clock(WorkClock clock);
[[nodiscard]] WorkClock work_clock();

/// Nanoseconds on that clock, since a moment that nobody knows. Profiling only, as Stopwatch.
[[nodiscard]] std::int64_t work_ns();

}  // namespace ff
