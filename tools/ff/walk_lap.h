#pragma once
// One lap of a walk: the loop that all share who measure frames.

#include <cstdint>
#include <span>
#include <type_traits>

#include "engine/core/work_clock.h"
#include "engine/gl/upload_count.h"
#include "tools/ff/heap_counter.h"
#include "tools/ff/session.h"

namespace ff::tool {

/// Frames of a lap before those that count as steady: caches fill, memory is taken.
inline constexpr std::size_t kWarmUpFrames = 4;

/// A frame that has just been drawn.
struct LapFrame {
    std::size_t frame = 0;
    double ms = 0.0;  ///< ticks of what is simulated, posing what moves, and drawing
    std::uint64_t allocations = 0, upload_bytes = 0;
    const frame::FrameStats& stats;
};

/// Draws the first frames of the session's walk, as if nothing had been drawn before.
/// @param before  called with a frame's number before it is posed; its time is nobody's
/// @param after   called with a LapFrame; an error that it returns ends the lap
/// Errors: that, and what the renderer refuses.
template <class Before, class After>
Status draw_lap(Session& session, frame::Renderer& renderer, frame::FrameSettings settings, const ImageSize& size,
                std::size_t frames, shading::Image& image, Before&& before, After&& after) {
    renderer.reset();
    for (std::size_t f = 0; f < frames; ++f) {
        before(f);
        const std::uint64_t allocations = heap_allocations(), uploaded = gl::uploaded_bytes();
        const std::int64_t begin_ns = work_ns();
        session.set_time(f, settings);
        const std::span<const scene::Instance> dynamic = session.dynamic(f, size);
        const double pose_ms = 1e-6 * double(work_ns() - begin_ns);
        const frame::FrameStats& stats = renderer.draw(session.walk().camera(f), dynamic, settings, image);
        FF_TRY(renderer.refusal());
        const LapFrame drawn{.frame = f,
                             .ms = pose_ms + stats.frame_ms,
                             .allocations = heap_allocations() - allocations,
                             .upload_bytes = gl::uploaded_bytes() - uploaded,
                             .stats = stats};
        if constexpr (std::is_void_v<decltype(after(drawn))>)
            after(drawn);
        else
            FF_TRY(after(drawn));
    }
    return {};
}

/// The same for who has nothing to do before a frame.
template <class After>
Status draw_lap(Session& session, frame::Renderer& renderer, const frame::FrameSettings& settings,
                const ImageSize& size, std::size_t frames, shading::Image& image, After&& after) {
    return draw_lap(
        session, renderer, settings, size, frames, image, [](std::size_t) {}, after);
}

}  // namespace ff::tool
