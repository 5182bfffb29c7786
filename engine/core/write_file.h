#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "engine/core/result.h"

namespace ff {

enum class Flush : unsigned char {
    to_disk,  ///< fsync: the file is there after the machine lost its power
    none,     ///< for what is checked when it is read and can be made again
};

/// Writes a file whole or not at all: into a neighbour, fsync, rename. What stood there before stays until the rename.
Status write_file_whole(const std::filesystem::path& path, std::span<const std::byte> bytes,
                        Flush flush = Flush::to_disk);
Status write_file_whole(const std::filesystem::path& path, std::string_view text);

/// The whole file as text. Errors: not there, not readable.
Result<std::string> read_text_file(const std::filesystem::path& path);

}  // namespace ff
