#pragma once
// Shaders under work: files of a folder instead of those that were built in.

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/core/result.h"

namespace ff::gl {

/// From now on programs are compiled from FOLDER/NAME where there is such a file; empty: from what is built in.
/// Threads: the window's.
void use_shader_folder(const std::filesystem::path& folder);

/// A shader's text, #includes resolved. Errors (bad input): a file or what it includes cannot be read.
[[nodiscard]] Result<std::string> shader_text(std::string_view name);

}  // namespace ff::gl
