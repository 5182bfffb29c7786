#pragma once
// Plays a game in a window: title, settings, pause, saving and loading, end.

#include <filesystem>
#include <functional>
#include <optional>

#include "engine/host/game.h"
#include "engine/shading/shading_pass.h"

namespace ff::host {

struct PlayOptions {
    std::filesystem::path pack;    ///< the world
    std::filesystem::path folder;  ///< settings, saves, recordings; empty: player_folder() of the game
    std::uint64_t seed = 1;
    std::optional<double> budget_ms;  ///< instead of the player's
    bool record = true;               ///< every session, into FOLDER/recordings
    bool skip_title = false;          ///< begins at once
    /// Writes a picture that the player takes; null: there is no key for it.
    std::function<Status(const std::filesystem::path&, const shading::Image&)> write_picture;
};

/// Until the player quits. Errors: no display, no such pack, a world that the game cannot be played in, settings that
/// cannot be read.
Status play(const GameInfo& info, const PlayOptions& options);

}  // namespace ff::host
