#include "tools/accuracy/schedule.h"

#include <algorithm>

#include "engine/core/check.h"

namespace ff::accuracy {

std::vector<ScheduledFrame> schedule(std::size_t walk_frames, const Effort& effort) {
    FF_CHECK(walk_frames > 0 && effort.segments > 0 && effort.counted_frames > 0 && effort.warm_up_frames >= 0,
             "{} frames in {} segments", walk_frames, effort.segments);
    const auto wanted = std::size_t(effort.warm_up_frames + effort.counted_frames);
    const std::size_t length = std::min(wanted, walk_frames);
    const std::size_t segments = std::min(std::size_t(effort.segments), walk_frames / length);
    const std::size_t warm_up = std::min(std::size_t(effort.warm_up_frames), length - 1);
    std::vector<ScheduledFrame> frames;
    for (std::size_t s = 0; s < segments; ++s) {
        // The first segment starts with the walk, the last one ends with it.
        const std::size_t start = segments > 1 ? s * (walk_frames - length) / (segments - 1) : 0;
        for (std::size_t i = 0; i < length; ++i) frames.push_back({start + i, i >= warm_up, i == 0});
    }
    return frames;
}

}  // namespace ff::accuracy
