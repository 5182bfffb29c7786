#include "engine/host/play_alone.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engine/core/log.h"
#include "engine/core/quantile.h"
#include "engine/core/stopwatch.h"
#include "engine/host/player_settings.h"
#include "engine/host/random_player.h"
#include "engine/host/session.h"
#include "engine/host/view_drawer.h"
#include "engine/scene/load_world.h"

namespace ff::host {
namespace {

constexpr std::uint64_t kTicksPerFrame = kTicksPerSecond / 30;

/// Draws what nobody sees, to know how long it takes and that it can be drawn.
class BlindDrawer {
  public:
    explicit BlindDrawer(scene::World& world) : drawer_(world, nullptr) {}

    Status draw(Game& game) {
        game.show(0.0, view_);
        FF_TRY(drawer_.draw(view_, 640, 480, {}, image_));
        frame_ms_.push_back(drawer_.stats().frame_ms);
        return {};
    }
    [[nodiscard]] const std::vector<double>& frame_ms() const { return frame_ms_; }

  private:
    ViewDrawer drawer_;
    GameView view_;
    shading::Image image_;
    std::vector<double> frame_ms_;
};

}  // namespace

Status play_alone(const GameInfo& info, const PlayAloneOptions& options) {
    if (options.player == AutoPlayerKind::winner && !info.winner)
        return usage_error(fmt::format("{}: nobody knows how to win this game; the player 'random' does", info.title));
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(options.pack));
    SessionSettings settings{.seed = options.seed,
                             .pack_name = std::filesystem::absolute(options.pack).string(),
                             .player_settings = {},
                             .recording = {},
                             .start = {},
                             .start_version = 0};
    if (options.record) {
        const std::filesystem::path folder = options.folder.empty() ? player_folder(info.name) : options.folder;
        settings.recording =
            options.recording.empty() ? new_recording_path(folder / "recordings", info) : options.recording;
    }
    FF_ASSIGN(const std::unique_ptr<Session> session, Session::begin(info, *world, settings));
    const auto player = options.player == AutoPlayerKind::winner ? info.winner(session->game(), options.seed)
                                                                 : make_random_player(info, options.seed);
    std::optional<BlindDrawer> drawer;
    if (options.draw) drawer.emplace(*world);
    double tick_s = 0.0;
    {
        Progress progress("playing", options.ticks);
        for (std::uint64_t t = 0; t < options.ticks && session->game().stage() == Stage::playing; ++t) {
            if (drawer && t % kTicksPerFrame == 0) FF_TRY(drawer->draw(session->game()));
            const Stopwatch clock;
            session->tick(player->next());
            tick_s += clock.seconds();
            progress.advance();
        }
    }
    FF_TRY(session->close());
    const std::uint64_t played = session->game().ticks();
    constexpr const char* kStages[] = {"still going", "won", "lost"};
    log_info("{}: {} after {} ticks, {:.1f} minutes of game time; {:.1f} us a tick", info.title,
             kStages[int(session->game().stage())], played, double(played) / kTicksPerSecond / 60.0,
             1e6 * tick_s / double(std::max<std::uint64_t>(1, played)));
    log_info("{}", session->game().status());
    if (drawer)
        log_info("{} frames of 640x480: median {:.2f} ms, 99th percentile {:.2f}", drawer->frame_ms().size(),
                 median_of(drawer->frame_ms()), quantile_of(drawer->frame_ms(), 0.99));
    if (!settings.recording.empty()) log_info("{}", settings.recording.string());
    return {};
}

}  // namespace ff::host
