#pragma once
// Wall time cut into ticks of one length, so that the simulation is the same whatever the frame rate.
//
// Based on: Fiedler, "Fix Your Timestep!", gafferongames.com, 2004. Ours differs: the remainder is kept in whole
// numbers, as nanoseconds times ticks a second, so that no tick is gained or lost in any number of frames.

#include <cstdint>

namespace ff::loop {

struct FixedStepSettings {
    int ticks_per_second = 120;  ///< [1, 10000]
    /// Ticks of one frame at most; what is beyond is dropped, so that a game that was halted goes on where it was
    /// instead of catching up, and one that is too slow runs slow instead of ever slower. [1, 10000]
    int max_ticks = 12;
};

class FixedStep {
  public:
    /// FF_CHECKs the ranges of the settings.
    explicit FixedStep(const FixedStepSettings& settings = {});

    /// @param dt_ns  since the last call, by a clock that may stand still, leap, or go backwards: less than 0 is 0
    /// @return ticks to simulate now, [0, max_ticks]
    int advance(std::int64_t dt_ns);

    /// How far the time is from the last tick to the next, [0, 1): what rendering interpolates by.
    [[nodiscard]] double fraction() const;
    [[nodiscard]] std::uint64_t ticks() const { return ticks_; }                  ///< returned so far
    [[nodiscard]] std::uint64_t dropped_ticks() const { return dropped_ticks_; }  ///< beyond max_ticks

  private:
    FixedStepSettings settings_;
    std::uint64_t remainder_ = 0;  ///< nanoseconds times ticks a second, below 1e9
    std::uint64_t ticks_ = 0, dropped_ticks_ = 0;
};

}  // namespace ff::loop
