#pragma once
// Frames as a trace that ui.perfetto.dev and chrome://tracing open: the Trace Event Format's JSON, "Trace Event Format"
// by N. Duca and D. Sinclair, Google 2016.
//
// A process a run (a mode, a lap); in it a thread "frames" with each frame and within it its passes, a thread "effects"
// with what effects took, and counter tracks: milliseconds of passes and effects, pixels by source, rays, allocations,
// what the plan chose.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/frame/stats.h"

namespace ff::debug {

class Trace {
  public:
    /// @param frames  that will be added at most, so that adding them allocates nothing
    explicit Trace(std::size_t frames) { frames_.reserve(frames); }

    /// Frames that follow belong to it. @param name  for people
    void begin_process(std::string_view name) { processes_.emplace_back(name); }
    /// A frame that has been drawn; in the order in which they were. Before any begin_process they are of "frames".
    void add(std::uint64_t number, std::uint64_t allocations, const frame::FrameStats& stats);
    [[nodiscard]] bool empty() const { return frames_.empty(); }

    /// {"displayTimeUnit": "ms", "traceEvents": [..]}, a line an event, by time; times begin with the first frame.
    [[nodiscard]] std::string to_json() const;

  private:
    struct Frame {
        std::size_t process;
        std::uint64_t number, allocations;
        frame::FrameStats stats;
    };
    std::vector<std::string> processes_;
    std::vector<Frame> frames_;  // 2.5 KiB each
};

}  // namespace ff::debug
