#include "engine/host/session.h"

#include <fmt/format.h>

#include "engine/core/log.h"

namespace ff::host {

Result<std::unique_ptr<Session>> Session::begin(const GameInfo& info, const scene::World& world,
                                                const SessionSettings& settings) {
    FF_ASSIGN(std::unique_ptr<Game> game, info.begin(world, settings.seed));
    if (!settings.start.empty()) FF_TRY(game->load(settings.start, settings.start_version));
    std::unique_ptr<Session> session(new Session(info, std::move(game)));
    if (settings.recording.empty()) return session;
    replay::SessionHeader header{.game = info.name,
                                 .engine_version = FF_VERSION,
                                 .pack = settings.pack_name,
                                 .pack_hash = world.statistics().pack_hash,
                                 .seed = settings.seed,
                                 .ticks_per_second = kTicksPerSecond,
                                 .settings = settings.player_settings,
                                 .start = {}};
    // What the game made of it, in its present version.
    if (!settings.start.empty()) header.start = session->game_->save();
    FF_ASSIGN(replay::Recorder recorder, replay::Recorder::create(settings.recording, header));
    session->recorder_.emplace(std::move(recorder));
    return session;
}

int Session::advance(const platform::InputState& input, std::int64_t dt_ns, loop::Controls& controls,
                     double turn_scale) {
    controls.turn(input, double(dt_ns) * 1e-9, turn_scale);
    const auto pressed = pending_.keys_pressed | input.keys_pressed;
    pending_ = input;
    pending_.keys_pressed = pressed;
    const int ticks = step_.advance(dt_ns);
    if (ticks == 0) return 0;
    // What was pressed and let go again between two frames is held for one tick.
    tick(controls.command(pending_));
    pending_.keys_pressed.reset();
    const loop::UserCommand command = controls.command(pending_);
    for (int i = 1; i < ticks; ++i) tick(command);
    return ticks;
}

void Session::tick(const loop::UserCommand& command) {
    const bool recorded = recorder_ && recorder_->status();
    if (recorded) recorder_->begin_tick(command);
    game_->tick(command);
    if (!recorded) return;
    recorder_->end_tick(game_->digest());
    if (!recorder_->status()) log_warning("{}", recorder_->status().error().message);
}

void Session::show(const loop::Controls& controls, GameView& out) {
    game_->show(step_.fraction(), out);
    out.camera.yaw = controls.yaw();
    out.camera.pitch = controls.pitch();
}

void Session::mark(std::string_view comment) {
    if (recorder_) recorder_->mark(comment);
}

Status Session::close() {
    return recorder_ ? recorder_->close() : Status{};
}

std::filesystem::path new_recording_path(const std::filesystem::path& folder, const GameInfo& info) {
    std::filesystem::path path;
    for (int n = 1; path.empty() || std::filesystem::exists(path); ++n)
        path = folder / fmt::format("{}-{}.ffreplay", info.name, n);
    return path;
}

}  // namespace ff::host
