#pragma once
// What the measuring subcommands keep of frames beside their own figures, for ff report and for traces.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "engine/debug/trace.h"
#include "tools/ff/session.h"
#include "tools/report/frame_series.h"

namespace ff::tool {

/// Slow frames that reports show with their pictures.
inline constexpr std::size_t kWorstPictures = 4;

/// Draws the walk once more, up to the last of some frames, and keeps these.
/// @param series  where their times are taken from. Errors: what the renderer refuses.
Result<std::vector<report::FramePicture>> draw_pictures(Session& session, frame::Renderer& renderer,
                                                        const frame::FrameSettings& settings, const ImageSize& size,
                                                        std::vector<std::size_t> frames,
                                                        const report::FrameSeries& series);

/// The series as JSON, with "pictures" of its slowest frames beside "frames" in `out`.
Status add_frames(Session& session, frame::Renderer& renderer, const frame::FrameSettings& settings,
                  const ImageSize& size, const report::FrameSeries& series, nlohmann::json& out);

/// Writes a trace and says where.
Status write_trace(const std::filesystem::path& path, const debug::Trace& trace);

}  // namespace ff::tool
