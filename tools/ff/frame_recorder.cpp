#include "tools/ff/frame_recorder.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/core/log.h"
#include "engine/core/write_file.h"
#include "tools/ff/walk_lap.h"

namespace ff::tool {

Result<std::vector<report::FramePicture>> draw_pictures(Session& session, frame::Renderer& renderer,
                                                        const frame::FrameSettings& settings, const ImageSize& size,
                                                        std::vector<std::size_t> frames,
                                                        const report::FrameSeries& series) {
    std::vector<report::FramePicture> pictures;
    if (frames.empty()) return pictures;
    std::sort(frames.begin(), frames.end());
    shading::Image image;
    FF_TRY(draw_lap(session, renderer, settings, size, frames.back() + 1, image, [&](const LapFrame& drawn) {
        if (!std::binary_search(frames.begin(), frames.end(), drawn.frame)) return;
        pictures.push_back({.frame = drawn.frame,
                            .ms = series.ms(drawn.frame),
                            .plan = frame::to_text(renderer.plan()),
                            .image = image});
    }));
    return pictures;
}

Status add_frames(Session& session, frame::Renderer& renderer, const frame::FrameSettings& settings,
                  const ImageSize& size, const report::FrameSeries& series, nlohmann::json& out) {
    FF_ASSIGN(const auto pictures, draw_pictures(session, renderer, settings, size,
                                                 series.worst_frames(kWorstPictures, kWarmUpFrames), series));
    out["frames"] = series.to_json();
    FF_ASSIGN(out["pictures"], report::to_json(pictures));
    return {};
}

Status write_trace(const std::filesystem::path& path, const debug::Trace& trace) {
    FF_TRY(write_file_whole(path, trace.to_json()));
    log_info("{}: a trace; open it in ui.perfetto.dev or chrome://tracing", path.string());
    return {};
}

}  // namespace ff::tool
