#pragma once
// A game being played: ticks cut from time, each recorded, saved games.

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/host/game.h"
#include "engine/loop/fixed_step.h"
#include "engine/replay/recorder.h"

namespace ff::host {

struct SessionSettings {
    std::uint64_t seed = 1;
    std::string pack_name;            ///< for people
    std::string player_settings;      ///< text, kept in recordings
    std::filesystem::path recording;  ///< file to write; empty: none
    std::vector<std::byte> start;     ///< a saved state to go on from; empty: from the beginning
    std::uint32_t start_version = 0;  ///< of it
};

class Session {
  public:
    /// Borrows info and world; they must outlive it. Errors: the game's own, or the recording cannot be made.
    static Result<std::unique_ptr<Session>> begin(const GameInfo& info, const scene::World& world,
                                                  const SessionSettings& settings);

    /// Runs the ticks that `dt_ns` more make due. @param turn_scale  of the last view
    /// @return ticks run
    int advance(const platform::InputState& input, std::int64_t dt_ns, loop::Controls& controls, double turn_scale);
    /// Runs one tick with this command, whatever the time.
    void tick(const loop::UserCommand& command);
    /// What is seen now; the camera looks where the controls do, newer than the last tick.
    void show(const loop::Controls& controls, GameView& out);
    /// A comment in the recording.
    void mark(std::string_view comment);
    /// Ends the recording. Errors: it could not be written.
    Status close();

    [[nodiscard]] Game& game() { return *game_; }
    [[nodiscard]] const GameInfo& info() const { return info_; }

  private:
    Session(const GameInfo& info, std::unique_ptr<Game> game) : info_(info), game_(std::move(game)) {}

    const GameInfo& info_;
    std::unique_ptr<Game> game_;
    std::optional<replay::Recorder> recorder_;
    loop::FixedStep step_{{.ticks_per_second = kTicksPerSecond}};
    platform::InputState pending_;  ///< what was pressed since the last tick
};

/// A recording's name that no file has: FOLDER/GAME-N.ffreplay.
[[nodiscard]] std::filesystem::path new_recording_path(const std::filesystem::path& folder, const GameInfo& info);

}  // namespace ff::host
