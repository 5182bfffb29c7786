#pragma once
// Times of a walk's frames, lap by lap.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace ff::budget {

/// Rows of figures, [lap][frame][figure]. What disturbs a frame makes it slower, never faster, so the least of its
/// laps is what it takes on this machine; that comes down to a floor as laps are added, and stays there.
class LapTable {
  public:
    LapTable(std::size_t frames, std::size_t figures) : frames_(frames), figures_(figures) {}

    /// A lap of zeros, to be filled by at().
    void add_lap() { samples_.resize(samples_.size() + frames_ * figures_); }
    [[nodiscard]] std::size_t laps() const { return samples_.size() / (frames_ * figures_); }
    [[nodiscard]] std::size_t frames() const { return frames_; }
    /// Of the last lap.
    [[nodiscard]] double& at(std::size_t frame, std::size_t figure) {
        return samples_[(laps() - 1) * frames_ * figures_ + frame * figures_ + figure];
    }
    [[nodiscard]] double sample(std::size_t lap, std::size_t frame, std::size_t figure) const {
        return samples_[(lap * frames_ + frame) * figures_ + figure];
    }
    /// The least of all laps.
    [[nodiscard]] double least(std::size_t frame, std::size_t figure) const {
        double value = std::numeric_limits<double>::infinity();
        for (std::size_t lap = 0; lap < laps(); ++lap) value = std::min(value, sample(lap, frame, figure));
        return value;
    }

  private:
    std::size_t frames_, figures_;
    std::vector<double> samples_;
};

}  // namespace ff::budget
