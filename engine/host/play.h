#pragma once
// Plays a game in a window: title, settings, pause, saving and loading, end.

#include <filesystem>
#include <optional>

#include "engine/host/game.h"

namespace ff::host {

struct PlayOptions {
    std::filesystem::path pack;    ///< the world
    std::filesystem::path folder;  ///< settings, saves, recordings; empty: player_folder() of the game
    std::uint64_t seed = 1;
    std::optional<double> budget_ms;  ///< instead of the player's
    bool record = true;               ///< every session, into FOLDER/recordings
    bool skip_title = false;          ///< begins at once
};

/// Until the player quits. Errors: no display, no such pack, a world that the game cannot be played in, settings that
/// cannot be read.
Status play(const GameInfo& info, const PlayOptions& options);

}  // namespace ff::host
