#include "engine/host/frame_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ff::host {

void FrameLog::add(double ms, int drawn_width, int width) {
    const double bin = std::clamp(ms / kBinMs, 0.0, double(bins_.size() - 1));
    ++bins_[std::size_t(bin)];
    ++frames_;
    worst_ms_ = std::max(worst_ms_, ms);
    if (drawn_width >= width) return;
    ++coarser_;
    coarsest_ = std::min(coarsest_, double(drawn_width) / double(width));
}

double FrameLog::quantile_ms(double share) const {
    const auto rank = std::uint64_t(std::ceil(share * double(frames_)));
    std::uint64_t below = 0;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
        below += bins_[bin];
        // The bin's upper end, so that what is printed was kept.
        if (below >= rank && below > 0) return std::min(worst_ms_, double(bin + 1) * kBinMs);
    }
    return worst_ms_;
}

double FrameLog::coarser_share() const {
    return frames_ == 0 ? 0.0 : double(coarser_) / double(frames_);
}

std::string FrameLog::to_text() const {
    std::string text = fmt::format("{} frames: median {:.1f} ms, 99th percentile {:.1f}, worst {:.1f}; ", frames_,
                                   quantile_ms(0.5), quantile_ms(0.99), worst_ms_);
    if (coarser_ == 0) return text + "all at full size";
    return text + fmt::format(
                      "given up for the budget: {:.1f}% of the frames were drawn smaller, down to {:.0f}% of "
                      "the picture's width",
                      100.0 * coarser_share(), 100.0 * coarsest_);
}

}  // namespace ff::host
