#pragma once

#include <vector>

#include "tools/report/frame_series.h"

namespace ff::report {

/// The slowest frames of a run that cannot be drawn again, kFramesApart: kept as they pass.
class WorstFrames {
  public:
    explicit WorstFrames(std::size_t count) : count_(count) {}

    /// Whether keep() would keep a frame of this time.
    [[nodiscard]] bool wants(std::size_t frame, double ms) const;
    void keep(FramePicture picture);
    /// In the order in which they were drawn.
    [[nodiscard]] const std::vector<FramePicture>& pictures() const { return pictures_; }

  private:
    std::size_t count_;
    std::vector<FramePicture> pictures_;
};

}  // namespace ff::report
