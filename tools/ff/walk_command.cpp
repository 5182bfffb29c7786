#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/core/log.h"
#include "engine/core/quantile.h"
#include "engine/core/write_file.h"
#include "engine/platform/output.h"
#include "tools/ff/frame_recorder.h"
#include "tools/ff/session.h"
#include "tools/ff/stats_json.h"
#include "tools/ff/video_writer.h"
#include "tools/ff/walk_lap.h"
#include "tools/ff/walk_window.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {
namespace {

constexpr std::size_t kDefaultPictures = 8;

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::string() : std::string(value);
}

Status walk_headless(const WalkOptions& options) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return failure(fmt::format("{}: cannot create: {}", options.out.string(), error.message()));
    FF_ASSIGN(const std::unique_ptr<Session> session,
              Session::open(options.view, std::span(&options.view.frame.mode, 1)));
    const scene::Walk& walk = session->walk();
    const std::size_t every = options.every > 0 ? std::size_t(options.every)
                                                : std::max<std::size_t>(1, walk.frames.size() / kDefaultPictures);

    std::optional<VideoWriter> video;
    const std::filesystem::path video_path = options.out / "walk.mp4";
    if (options.video) {
        FF_ASSIGN(VideoWriter opened,
                  VideoWriter::open(video_path, options.view.size.width, options.view.size.height, walk.rate_hz));
        video.emplace(std::move(opened));
    }

    const auto renderer = session->make_renderer(options.view.size);
    shading::Image image;
    nlohmann::json frames = nlohmann::json::array();
    std::vector<double> times;
    std::size_t pictures = 0;
    debug::Trace trace(options.trace.empty() ? 0 : walk.frames.size());
    {
        Progress progress("walking", walk.frames.size());
        const auto keep = [&](const LapFrame& drawn) -> Status {
            frames.push_back(to_json(drawn.stats));
            times.push_back(drawn.stats.frame_ms);
            if (!options.trace.empty()) trace.add(drawn.frame, drawn.allocations, drawn.stats);
            if (drawn.frame % every == 0) {
                FF_TRY(write_image(options.out / fmt::format("frame{:05}.png", drawn.frame), image));
                ++pictures;
            }
            if (video) FF_TRY(video->add(image));
            progress.advance();
            return {};
        };
        FF_TRY(draw_lap(*session, *renderer, session->settings(), options.view.size, walk.frames.size(), image, keep));
    }
    if (!options.trace.empty()) FF_TRY(write_trace(options.trace, trace));
    if (video) FF_TRY(video->close());

    const double median = median_of(times), p99 = quantile_of(times, 0.99);
    const double worst = *std::max_element(times.begin(), times.end());
    const nlohmann::json stats{{"scene", session->world().info().name},
                               {"walk", walk.name},
                               {"width", options.view.size.width},
                               {"height", options.view.size.height},
                               {"gl_renderer", session->gl_renderer_name()},
                               {"frame_ms", {{"median", median}, {"p99", p99}, {"max", worst}}},
                               {"frames", frames}};
    FF_TRY(write_file_whole(options.out / "stats.json", stats.dump(1)));
    log_info("walked '{}' of {}: {} frames, median {:.2f} ms, worst {:.2f} ms", walk.name, session->world().info().name,
             times.size(), median, worst);
    log_info("{}: {} pictures{} and stats.json", std::filesystem::absolute(options.out).string(), pictures,
             video ? ", walk.mp4" : "");
    return {};
}

}  // namespace

Status run_walk(const WalkOptions& options) {
    const auto wish = options.target == WalkTarget::window     ? platform::OutputWish::window
                      : options.target == WalkTarget::headless ? platform::OutputWish::headless
                                                               : platform::OutputWish::either;
    if (platform::choose_output(wish, environment("DISPLAY"), environment("WAYLAND_DISPLAY")) ==
        platform::Output::window)
        return walk_in_window(options);
    if (wish == platform::OutputWish::either)
        log_info("no display (DISPLAY and WAYLAND_DISPLAY are empty): walking headless into {}", options.out.string());
    return walk_headless(options);
}

}  // namespace ff::tool
