#pragma once
// What a player sets, in a file that people may edit.

#include <filesystem>
#include <string>

#include "engine/core/result.h"
#include "engine/loop/controls.h"

namespace ff::host {

struct PlayerSettings {
    double fov_deg = 0.0;     ///< vertical, [30, 110]; 0: the game's own
    double budget_ms = 30.0;  ///< a frame may take so long, [0, 1000]; 0: error_px rules
    /// Without a budget: how far what is seen again may be shifted against what is right, pixels of parallax, [0, 16];
    /// 0: exact frames.
    double error_px = 0.0;
    int width = 640, height = 480;  ///< of the picture, [64, 8192]; the window scales it
    bool fullscreen = false;
    double volume = 0.8;       ///< of all sound, [0, 1]; 0: no sound device is opened
    double mouse_speed = 1.0;  ///< [0.05, 20]
    bool invert_pitch = false;
    std::vector<loop::Action> actions;  ///< the game's, with the player's keys
};

/// The game's own settings.
[[nodiscard]] PlayerSettings default_settings(std::span<const loop::Action> actions);

/// TOML text that read_settings reads.
[[nodiscard]] std::string to_text(const PlayerSettings& settings);
/// Keys that are not there keep the game's values. Errors (bad input): file, line and what was expected.
[[nodiscard]] Result<PlayerSettings> read_settings(const std::string& text, const std::string& file,
                                                   std::span<const loop::Action> actions);

/// Where a game keeps what belongs to the player: settings, saves, recordings. The environment's XDG_DATA_HOME, else
/// ~/.local/share.
[[nodiscard]] std::filesystem::path player_folder(const std::string& game);

}  // namespace ff::host
