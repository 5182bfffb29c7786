#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/host/frame_log.h"
#include "engine/host/replay_session.h"
#include "engine/scene/load_world.h"
#include "game/beacons/beacons_game.h"
#include "tools/ff/frame_recorder.h"
#include "tools/ff/machine.h"
#include "tools/ff/replay_drawer.h"
#include "tools/ff/session.h"
#include "tools/ff/video_writer.h"
#include "tools/ff/walk_lap.h"
#include "tools/picture/picture_file.h"
#include "tools/report/worst_frames.h"

namespace ff::tool {
namespace {

/// What a replay leaves of the frames that it draws.
class ReplayFrames {
  public:
    ReplayFrames(const ReplayOptions& options, scene::World& world, std::size_t frames)
        : drawer_(world, options.size, options.budget_ms),
          series_(frames),
          worst_(options.each_frame ? kWorstPictures : 0),
          trace_(options.trace.empty() ? 0 : frames),
          traces_(!options.trace.empty()) {}

    Status open_video(const ReplayOptions& options) {
        FF_ASSIGN(VideoWriter video,
                  VideoWriter::open(options.video, options.size.width, options.size.height, kReplayFramesPerSecond));
        video_.emplace(std::move(video));
        return {};
    }
    /// @param ticks_s  seconds that the ticks since the last frame took: a frame's time has all of it
    Status draw(host::Game& game, double ticks_s) {
        FF_TRY(drawer_.draw(game));
        const double ms = drawer_.frame_ms() + 1e3 * ticks_s;
        const std::size_t frame = log_.frames();
        log_.add(ms, drawer_.plan().view.width, drawer_.plan().image_width);
        series_.add(drawer_.view().camera, ms, report::work_of(drawer_.stats(), drawer_.allocations(), 0),
                    drawer_.stats());
        if (traces_) trace_.add(frame, drawer_.allocations(), drawer_.stats());
        if (frame >= kWarmUpFrames && worst_.wants(frame, ms))
            worst_.keep({.frame = frame, .ms = ms, .plan = to_text(drawer_.plan()), .image = drawer_.image()});
        return video_ ? video_->add(drawer_.image()) : Status{};
    }
    /// What the host draws before a session is played: later frames reuse what it builds.
    Status draw_before_play(host::Game& game) { return drawer_.draw_exact(game); }
    Status close() { return video_ ? video_->close() : Status{}; }
    [[nodiscard]] const shading::Image& image() const { return drawer_.image(); }
    [[nodiscard]] const host::FrameLog& log() const { return log_; }
    [[nodiscard]] const debug::Trace& trace() const { return trace_; }
    Status add_to(nlohmann::json& json) const {
        json["frames"] = series_.to_json();
        FF_ASSIGN(json["pictures"], report::to_json(worst_.pictures()));
        return {};
    }

  private:
    ReplayDrawer drawer_;
    std::optional<VideoWriter> video_;
    host::FrameLog log_;
    report::FrameSeries series_;
    report::WorstFrames worst_;
    debug::Trace trace_;
    bool traces_;
};

nlohmann::json report_of(const replay::Recording& recording, std::uint64_t played, double tick_us,
                         const std::optional<host::Divergence>& divergence, const host::FrameLog* frames) {
    nlohmann::json markers = nlohmann::json::array();
    for (const replay::Marker& marker : recording.markers)
        markers.push_back({{"tick", marker.tick}, {"comment", marker.comment}});
    nlohmann::json json{{"kind", "replay"},
                        {"game", recording.header.game},
                        {"pack", recording.header.pack},
                        {"ticks", recording.commands.size()},
                        {"played", played},
                        {"closed", recording.closed},
                        {"tick_us", tick_us},
                        {"markers", markers},
                        {"divergence", nullptr}};
    if (divergence) {
        json["divergence"] = {
            {"tick", divergence->tick}, {"entity", nullptr}, {"description", divergence->description}};
        if (divergence->entity) json["divergence"]["entity"] = *divergence->entity;
    }
    if (frames != nullptr && frames->frames() > 0)
        json["frame_ms"] = {{"frames", frames->frames()},
                            {"median", frames->quantile_ms(0.5)},
                            {"p99", frames->quantile_ms(0.99)},
                            {"max", frames->worst_ms()},
                            {"coarser_share", frames->coarser_share()},
                            {"coarsest", frames->coarsest()}};
    return json;
}

}  // namespace

Status run_replay(const ReplayOptions& options) {
    if (!options.bench && (options.each_frame || !options.trace.empty()))
        return usage_error("--each-frame and --trace are of the frames that --bench draws: it is missing");
    FF_ASSIGN(const replay::Recording recording, replay::load_recording(options.recording));
    if (!recording.closed)
        log_info("{}: was not closed in order; {} ticks, the last one {}", options.recording.string(),
                 recording.commands.size(),
                 recording.digests.size() < recording.commands.size() ? "did not end" : "ended");
    FF_ASSIGN(const std::filesystem::path pack, pack_of(options.pack.empty() ? recording.header.pack : options.pack));
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(pack));
    auto session = host::ReplaySession::begin(beacons::game_info(), *world, recording);
    if (!session) return bad_input(fmt::format("{}: {}", options.recording.string(), session.error().message));

    const std::uint64_t end = std::min<std::uint64_t>(options.until.value_or(UINT64_MAX), recording.commands.size());
    const std::size_t frames = end / kTicksPerFrame + 2;
    std::optional<ReplayFrames> drawer;
    if (options.bench || !options.video.empty()) drawer.emplace(options, *world, frames);
    if (!options.video.empty()) FF_TRY(drawer->open_video(options));
    if (drawer) FF_TRY(drawer->draw_before_play(session->game()));
    double tick_s = 0.0, tick_s_of_frame = 0.0;
    {
        Progress progress("replaying", end);
        while (session->tick() < end && !(options.verify && session->divergence())) {
            if (drawer && session->tick() % kTicksPerFrame == 0) {
                FF_TRY(drawer->draw(session->game(), tick_s - tick_s_of_frame));
                tick_s_of_frame = tick_s;
            }
            const Stopwatch clock;
            session->step();
            tick_s += clock.seconds();
            progress.advance();
        }
    }
    if (drawer) FF_TRY(drawer->close());
    if (!options.picture.empty()) {
        if (!drawer) drawer.emplace(options, *world, frames);
        FF_TRY(drawer->draw(session->game(), 0.0));
        FF_TRY(write_image(options.picture, drawer->image()));
    }
    const double tick_us = 1e6 * tick_s / double(std::max<std::uint64_t>(1, session->tick()));
    if (drawer && !options.trace.empty()) FF_TRY(write_trace(options.trace, drawer->trace()));
    if (options.json) {
        nlohmann::json json =
            report_of(recording, session->tick(), tick_us, session->divergence(), drawer ? &drawer->log() : nullptr);
        json["machine"] = {{"cpu", cpu_name()}, {"threads", worker_count()}};
        if (drawer)
            json["settings"] = {
                {"width", options.size.width}, {"height", options.size.height}, {"budget_ms", options.budget_ms}};
        if (drawer && options.each_frame) FF_TRY(drawer->add_to(json));
        std::printf("%s\n", json.dump(1).c_str());
    }
    log_info("{} of {} ticks, {:.1f} us each", session->tick(), recording.commands.size(), tick_us);
    if (drawer) log_info("{}", drawer->log().to_text());
    log_info("{}", session->game().status());
    for (const replay::Marker& marker : recording.markers) log_info("tick {}: {}", marker.tick, marker.comment);
    if (session->divergence()) {
        const std::string text = fmt::format("{}: {}", options.recording.string(), to_text(*session->divergence()));
        if (options.verify) return Error{ErrorKind::limit, text};
        log_warning("{}", text);
    } else if (options.verify) {
        log_info("every tick as recorded");
    }
    return {};
}

}  // namespace ff::tool
