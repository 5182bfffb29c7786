#pragma once
// A game played by a program instead of a person, without a window and as fast as it goes.

#include <cstdint>
#include <filesystem>

#include "engine/host/game.h"

namespace ff::host {

enum class AutoPlayerKind : std::uint8_t { random, winner };

struct PlayAloneOptions {
    std::filesystem::path pack;    ///< the world
    std::filesystem::path folder;  ///< of recordings; empty: player_folder() of the game
    AutoPlayerKind player = AutoPlayerKind::random;
    std::uint64_t seed = 1;
    std::uint64_t ticks = 20 * 60 * kTicksPerSecond;  ///< at most
    bool record = true;
    std::filesystem::path recording;  ///< file; empty: a new one in FOLDER/recordings
    bool draw = false;                ///< exact frames of 640x480, 30 a second of game time, that nobody sees
};

/// Plays until the game ends or the ticks are over; says how it went. Errors: usage, no winner in this game; no such
/// pack, a world that the game cannot be played in, a recording that cannot be written.
Status play_alone(const GameInfo& info, const PlayAloneOptions& options);

}  // namespace ff::host
