#pragma once
// Source images through OpenImageIO: PNG, JPEG, WebP, TIFF, EXR, HDR, TGA, BMP, ... to what a texture holds.

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "engine/core/result.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

inline constexpr std::uint32_t kMaxTextureSize = 4096;

/// Decodes an image file held in memory to RGBA8, resized to powers of two of at most kMaxTextureSize (each side to the
/// nearest one). Grey becomes RGB, a missing alpha 255, floating-point images are clipped to [0, 1] and sRGB-encoded.
/// @param name  for messages and as SourceTexture::name: file and place
/// Errors: bad_input with `name` when this is no image, is cut short, or is larger than 32768 pixels a side.
/// Cached by the bytes. Threads: any.
[[nodiscard]] Result<SourceTexture> decode_texture(std::span<const std::byte> bytes, const std::string& name,
                                                   CookContext& context);

/// The same from a file.
[[nodiscard]] Result<SourceTexture> load_texture(const std::filesystem::path& path, CookContext& context);

/// The whole file as bytes. Errors: bad_input, with the system's reason.
[[nodiscard]] Result<std::vector<std::byte>> read_file_bytes(const std::filesystem::path& path);

}  // namespace ff::cook
