#pragma once
// A recorded session: what the player commanded each tick, and a fingerprint of what came of it.
//
// A file grows record by record, so that what was recorded before a crash, a kill or a full disk is all there:
//
//   magic, version                        8 + 4 bytes
//   header                                length, JSON text, its xxHash3
//   record*                               a byte that names its kind, then its fields
//     tick    what changed in the command since the tick before
//     state   the digest after that tick
//     marker  a comment that the player typed
//     check   xxHash3 of all bytes since the last one; every second
//     end     the session was closed in order
//
// Numbers are little-endian; those that are mostly small are in groups of seven bits, lowest first.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/loop/user_command.h"
#include "engine/replay/state_hash.h"

namespace ff::replay {

/// What a session has to be told to begin in the same way.
struct SessionHeader {
    std::string game;             ///< which game's rules
    std::string engine_version;   ///< that recorded it
    std::string pack;             ///< file name of the world, for people
    std::uint64_t pack_hash = 0;  ///< of its contents
    std::uint64_t seed = 0;
    int ticks_per_second = 120;
    std::string settings;          ///< of the player, as their file has them
    std::vector<std::byte> start;  ///< a saved state that it goes on from; empty: from the beginning

    friend bool operator==(const SessionHeader&, const SessionHeader&) = default;
};

struct Marker {
    std::uint64_t tick = 0;  ///< ticks before it
    std::string comment;

    friend bool operator==(const Marker&, const Marker&) = default;
};

struct Recording {
    static constexpr int kVersion = 1;
    static constexpr std::size_t kMaxHeaderBytes = 64u << 20, kMaxCommentBytes = 4096;
    static constexpr std::uint64_t kMaxTicks = 50'000'000;

    SessionHeader header;
    std::vector<loop::UserCommand> commands;  ///< [ticks]
    std::vector<StateDigest> digests;         ///< [ticks], or one less: the last tick did not end
    std::vector<Marker> markers;
    bool closed = false;  ///< in order; else it ended with a crash, or was cut
};

/// Reads a recording. One that was cut is read up to its last whole record. Errors (bad input): not a recording, of
/// another version, damaged before its end; the message names the file and the byte.
[[nodiscard]] Result<Recording> load_recording(const std::filesystem::path& path);
/// The same from memory. @param name  in messages
[[nodiscard]] Result<Recording> parse_recording(std::span<const std::byte> bytes, const std::string& name);

}  // namespace ff::replay
