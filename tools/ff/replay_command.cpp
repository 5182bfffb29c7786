#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "engine/core/log.h"
#include "engine/core/quantile.h"
#include "engine/core/stopwatch.h"
#include "engine/host/replay_session.h"
#include "engine/host/view_drawer.h"
#include "engine/scene/load_world.h"
#include "game/beacons/beacons_game.h"
#include "tools/ff/session.h"
#include "tools/ff/video_writer.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {
namespace {

constexpr int kFramesPerSecond = 30;
constexpr std::uint64_t kTicksPerFrame = host::kTicksPerSecond / kFramesPerSecond;

/// Draws a replay as it goes.
class ReplayDrawer {
  public:
    ReplayDrawer(const ReplayOptions& options, scene::World& world) : drawer_(world, nullptr), size_(options.size) {
        settings_.budget_ms = options.budget_ms;
    }

    Status open_video(const ReplayOptions& options) {
        FF_ASSIGN(VideoWriter video,
                  VideoWriter::open(options.video, options.size.width, options.size.height, kFramesPerSecond));
        video_.emplace(std::move(video));
        return {};
    }
    Status draw(host::Game& game) {
        game.show(0.0, view_);
        FF_TRY(drawer_.draw(view_, size_.width, size_.height, settings_, image_));
        frame_ms_.push_back(drawer_.stats().frame_ms);
        return video_ ? video_->add(image_) : Status{};
    }
    [[nodiscard]] const shading::Image& image() const { return image_; }
    Status close() { return video_ ? video_->close() : Status{}; }
    [[nodiscard]] const std::vector<double>& frame_ms() const { return frame_ms_; }

  private:
    host::ViewDrawer drawer_;
    ImageSize size_;
    frame::FrameSettings settings_;
    host::GameView view_;
    shading::Image image_;
    std::optional<VideoWriter> video_;
    std::vector<double> frame_ms_;
};

void print_json(const replay::Recording& recording, std::uint64_t played, double tick_us,
                const std::optional<host::Divergence>& divergence, const std::vector<double>& frame_ms) {
    nlohmann::json markers = nlohmann::json::array();
    for (const replay::Marker& marker : recording.markers)
        markers.push_back({{"tick", marker.tick}, {"comment", marker.comment}});
    nlohmann::json json{{"game", recording.header.game},
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
    if (!frame_ms.empty())
        json["frame_ms"] = {{"frames", frame_ms.size()},
                            {"median", median_of(frame_ms)},
                            {"p99", quantile_of(frame_ms, 0.99)},
                            {"max", *std::max_element(frame_ms.begin(), frame_ms.end())}};
    std::printf("%s\n", json.dump(1).c_str());
}

}  // namespace

Status run_replay(const ReplayOptions& options) {
    FF_ASSIGN(const replay::Recording recording, replay::load_recording(options.recording));
    if (!recording.closed)
        log_info("{}: was not closed in order; {} ticks, the last one {}", options.recording.string(),
                 recording.commands.size(),
                 recording.digests.size() < recording.commands.size() ? "did not end" : "ended");
    FF_ASSIGN(const std::filesystem::path pack, pack_of(options.pack.empty() ? recording.header.pack : options.pack));
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(pack));
    auto session = host::ReplaySession::begin(beacons::game_info(), *world, recording);
    if (!session) return bad_input(fmt::format("{}: {}", options.recording.string(), session.error().message));

    std::optional<ReplayDrawer> drawer;
    if (options.bench || !options.video.empty()) drawer.emplace(options, *world);
    if (!options.video.empty()) FF_TRY(drawer->open_video(options));
    const std::uint64_t end = std::min<std::uint64_t>(options.until.value_or(UINT64_MAX), recording.commands.size());
    double tick_s = 0.0;
    {
        Progress progress("replaying", end);
        while (session->tick() < end && !(options.verify && session->divergence())) {
            if (drawer && session->tick() % kTicksPerFrame == 0) FF_TRY(drawer->draw(session->game()));
            const Stopwatch clock;
            session->step();
            tick_s += clock.seconds();
            progress.advance();
        }
    }
    if (drawer) FF_TRY(drawer->close());
    if (!options.picture.empty()) {
        if (!drawer) drawer.emplace(options, *world);
        FF_TRY(drawer->draw(session->game()));
        FF_TRY(write_image(options.picture, drawer->image()));
    }
    const double tick_us = 1e6 * tick_s / double(std::max<std::uint64_t>(1, session->tick()));
    if (options.json)
        print_json(recording, session->tick(), tick_us, session->divergence(),
                   drawer ? drawer->frame_ms() : std::vector<double>{});
    log_info("{} of {} ticks, {:.1f} us each", session->tick(), recording.commands.size(), tick_us);
    if (drawer)
        log_info("{} frames: median {:.2f} ms, 99th percentile {:.2f}", drawer->frame_ms().size(),
                 median_of(drawer->frame_ms()), quantile_of(drawer->frame_ms(), 0.99));
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
