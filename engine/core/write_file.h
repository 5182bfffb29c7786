#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "engine/core/result.h"
#include "engine/core/whole_file.h"

namespace ff {

/// Writes a file whole or not at all; what stood there before stays until then.
Status write_file_whole(const std::filesystem::path& path, std::span<const std::byte> bytes,
                        Flush flush = Flush::to_disk);
Status write_file_whole(const std::filesystem::path& path, std::string_view text);

/// The whole file as text. Errors: not there, not readable.
Result<std::string> read_text_file(const std::filesystem::path& path);

}  // namespace ff
