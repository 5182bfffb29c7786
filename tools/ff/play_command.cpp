#include <fmt/format.h>

#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/host/play.h"
#include "engine/host/player_settings.h"
#include "engine/host/random_player.h"
#include "engine/host/session.h"
#include "engine/scene/load_world.h"
#include "game/beacons/beacons_game.h"
#include "tools/ff/session.h"

namespace ff::tool {
namespace {

/// A session without a window, played by a program.
Status play_by_itself(const PlayOptions& options, const std::filesystem::path& pack) {
    const host::GameInfo& info = beacons::game_info();
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(pack));
    const std::filesystem::path folder = options.folder.empty() ? host::player_folder(info.name) : options.folder;
    host::SessionSettings settings{.seed = options.seed,
                                   .pack_name = std::filesystem::absolute(pack).string(),
                                   .player_settings = {},
                                   .recording = {},
                                   .start = {},
                                   .start_version = 0};
    if (options.record)
        settings.recording =
            options.recording.empty() ? host::new_recording_path(folder / "recordings", info) : options.recording;
    FF_ASSIGN(const std::unique_ptr<host::Session> session, host::Session::begin(info, *world, settings));
    const auto player = options.player == AutoPlayerKind::winner ? info.winner(session->game(), options.seed)
                                                                 : host::make_random_player(info, options.seed);
    const auto ticks = std::uint64_t(options.minutes * 60.0 * host::kTicksPerSecond);
    const Stopwatch clock;
    {
        Progress progress("playing", ticks);
        for (std::uint64_t t = 0; t < ticks && session->game().stage() == host::Stage::playing; ++t) {
            session->tick(player->next());
            progress.advance();
        }
    }
    FF_TRY(session->close());
    const std::uint64_t played = session->game().ticks();
    constexpr const char* kStages[] = {"still going", "won", "lost"};
    log_info("{}: {} after {} ticks, {:.1f} minutes of game time; {:.1f} s, {:.1f} us a tick", info.title,
             kStages[int(session->game().stage())], played, double(played) / host::kTicksPerSecond / 60.0,
             clock.seconds(), 1e6 * clock.seconds() / double(std::max<std::uint64_t>(1, played)));
    log_info("{}", session->game().status());
    if (!settings.recording.empty()) log_info("{}", settings.recording.string());
    return {};
}

}  // namespace

Status run_play(const PlayOptions& options) {
    FF_ASSIGN(const std::filesystem::path pack, pack_of(options.pack));
    if (options.player != AutoPlayerKind::none) return play_by_itself(options, pack);
    return host::play(beacons::game_info(), {.pack = pack,
                                             .folder = options.folder,
                                             .seed = options.seed,
                                             .budget_ms = options.budget_ms,
                                             .record = options.record,
                                             .skip_title = options.skip_title});
}

}  // namespace ff::tool
