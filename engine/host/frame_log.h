#pragma once
// How long the frames of a session took and what was given up to keep their budget, for one line at its end.

#include <array>
#include <cstdint>
#include <string>

namespace ff::host {

/// Fixed size: taking in a frame allocates nothing, however long a session lasts.
class FrameLog {
  public:
    /// @param ms      of the whole frame: ticks, recording, drawing, presenting
    /// @param drawn_width, width  of the picture: as it was drawn, and as it is shown
    void add(double ms, int drawn_width, int width);

    [[nodiscard]] std::uint64_t frames() const { return frames_; }
    /// The time that this share of the frames did not exceed, ms, to 0.1 ms. @param share  (0, 1]
    [[nodiscard]] double quantile_ms(double share) const;
    [[nodiscard]] double worst_ms() const { return worst_ms_; }
    /// Share of the frames that were drawn smaller than shown.
    [[nodiscard]] double coarser_share() const;
    /// The smallest share of the picture's sides at which one was drawn, (0, 1].
    [[nodiscard]] double coarsest() const { return coarsest_; }

    /// "2712 frames: median 24.1 ms, 99th percentile 31.0, worst 41.2; ..."; what was given up follows.
    [[nodiscard]] std::string to_text() const;

  private:
    static constexpr double kBinMs = 0.1;
    std::array<std::uint32_t, 20'000> bins_{};  ///< the last one: that long or longer
    std::uint64_t frames_ = 0, coarser_ = 0;
    double worst_ms_ = 0.0, coarsest_ = 1.0;
};

}  // namespace ff::host
