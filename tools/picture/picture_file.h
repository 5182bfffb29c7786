#pragma once
// Pictures as files.

#include <filesystem>

#include "engine/core/result.h"
#include "engine/shading/shading_pass.h"

namespace ff::tool {

/// Writes an image as PNG, EXR, JPEG ..., by the name's ending; whole or not at all.
/// Errors: the ending is no image format's (usage); the file cannot be written.
Status write_image(const std::filesystem::path& path, const shading::Image& image);

/// Reads the colours of an image of 8 bits and 3 or 4 channels; alpha becomes 255.
/// Errors: not there, not an image, of another kind.
Result<shading::Image> read_image(const std::filesystem::path& path);

}  // namespace ff::tool
