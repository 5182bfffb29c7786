#include <fmt/format.h>

#include "engine/core/log.h"
#include "tools/ff/image_file.h"
#include "tools/ff/session.h"

namespace ff::tool {

Status run_render(const RenderOptions& options) {
    FF_ASSIGN(const std::unique_ptr<Session> session,
              Session::open(options.view, std::span(&options.view.frame.mode, 1)));
    const std::size_t frames = session->walk().frames.size();
    if (std::size_t(options.frame) >= frames)
        return usage_error(fmt::format("--frame {}: the walk '{}' has frames 0 to {}", options.frame,
                                       session->walk().name, frames - 1));

    const auto renderer = session->make_renderer(options.view.size);
    shading::Image image;
    const frame::FrameStats& stats = renderer->draw(session->walk().camera(std::size_t(options.frame)),
                                                    session->dynamic(), options.view.frame, image);
    log_info("frame {} in {:.1f} ms: {} pixels near, {} sky, {} panorama, {} cast and hit, {} cast and missed",
             options.frame, stats.frame_ms, stats.pixels.near_field, stats.pixels.sky, stats.pixels.panorama,
             stats.pixels.cast_hit, stats.pixels.cast_miss);
    return write_image(options.output, image);
}

}  // namespace ff::tool
