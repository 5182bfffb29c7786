#include "tools/report/worst_frames.h"

#include <algorithm>
#include <utility>

namespace ff::report {
namespace {

bool is_faster(const FramePicture& a, const FramePicture& b) {
    return a.ms < b.ms;
}

}  // namespace

bool WorstFrames::wants(std::size_t frame, double ms) const {
    if (count_ == 0) return false;
    if (!pictures_.empty() && frame - pictures_.back().frame < kFramesApart) return ms > pictures_.back().ms;
    return pictures_.size() < count_ || ms > std::min_element(pictures_.begin(), pictures_.end(), is_faster)->ms;
}

void WorstFrames::keep(FramePicture picture) {
    if (!wants(picture.frame, picture.ms)) return;
    if (!pictures_.empty() && picture.frame - pictures_.back().frame < kFramesApart)
        pictures_.pop_back();
    else if (pictures_.size() == count_)
        pictures_.erase(std::min_element(pictures_.begin(), pictures_.end(), is_faster));
    pictures_.push_back(std::move(picture));
}

}  // namespace ff::report
