#pragma once
// Saved games on disk: a version, the game's own bytes, a checksum. The one before stays beside it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"

namespace ff::loop {

struct SavedGame {
    std::string game;           ///< whose it is, at most 255 bytes
    std::uint32_t version = 0;  ///< of the game's own bytes: the game reads all versions up to its own
    std::vector<std::byte> state;

    friend bool operator==(const SavedGame&, const SavedGame&) = default;
};

/// Where the save before this one is kept.
[[nodiscard]] std::filesystem::path previous_save(const std::filesystem::path& path);

/// Writes a save whole or not at all, at whatever moment the process ends; what stood there becomes the previous one.
/// Errors: the folder cannot be written; both earlier saves are as they were.
Status write_save(const std::filesystem::path& path, const SavedGame& save);

/// Reads one file. Errors (bad input): missing, damaged, not a save, of another game, of a newer version than `newest`.
[[nodiscard]] Result<SavedGame> read_save(const std::filesystem::path& path, const std::string& game,
                                          std::uint32_t newest);

struct LoadedSave {
    SavedGame save;
    std::string warning;  ///< empty, or why it is the previous one
};
/// Reads a save, or where that is missing or refused, the one before it. Errors: of both.
[[nodiscard]] Result<LoadedSave> load_save(const std::filesystem::path& path, const std::string& game,
                                           std::uint32_t newest);

}  // namespace ff::loop
