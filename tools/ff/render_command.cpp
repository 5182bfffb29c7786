#include <fmt/format.h>

#include <algorithm>

#include "engine/core/log.h"
#include "tools/ff/debug_picture.h"
#include "tools/ff/session.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {

Status run_render(const RenderOptions& options) {
    FF_ASSIGN(const std::unique_ptr<Session> session,
              Session::open(options.view, std::span(&options.view.frame.mode, 1)));
    const std::size_t frames = session->walk().frames.size();
    if (std::size_t(options.frame) >= frames)
        return usage_error(fmt::format("--frame {}: the walk '{}' has frames 0 to {}", options.frame,
                                       session->walk().name, frames - 1));

    // The frame as a walk would show it: what it reuses was drawn in the frames just before.
    constexpr std::size_t kLeadIn = 8;
    const auto renderer = session->make_renderer(options.view.size);
    shading::Image image;
    const auto last = std::size_t(options.frame);
    for (std::size_t f = last - std::min(last, kLeadIn); f < last; ++f)
        renderer->draw(session->walk().camera(f), session->dynamic(f, options.view.size), session->settings_at(f),
                       image);
    const frame::FrameStats& stats = renderer->draw(
        session->walk().camera(last), session->dynamic(last, options.view.size), session->settings_at(last), image);
    FF_TRY(renderer->refusal());
    log_info("frame {} in {:.1f} ms: {} pixels near, {} sky, {} panorama, {} cast and hit, {} cast and missed",
             options.frame, stats.frame_ms, stats.pixels.near_field, stats.pixels.sky, stats.pixels.panorama,
             stats.pixels.cast_hit, stats.pixels.cast_miss);
    for (std::size_t i = 0; i < kDebugViewNames.size(); ++i)
        if (options.debug_view == kDebugViewNames[i])
            draw_debug_view(DebugView(i), *renderer, session->casters(), image);
    return write_image(options.output, image);
}

}  // namespace ff::tool
