#pragma once
// The outside of a glTF model: the .gltf or .glb file, its JSON, and the bytes of its buffers and images, wherever they
// lie. What they mean is read elsewhere.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "tools/cook/cook_context.h"

namespace ff::cook {

using Bytes = std::span<const std::byte>;

struct GltfFile {
    std::string name;  ///< for messages: the path as given
    std::filesystem::path folder;
    nlohmann::json json;  ///< an object; nested at most kMaxJsonDepth deep
    std::vector<std::byte> file_bytes;
    Bytes binary_chunk;  ///< of a .glb, inside file_bytes; empty where there is none
    bool has_binary_chunk = false;
    std::vector<std::unique_ptr<std::vector<std::byte>>> loaded;  ///< owners of what URIs named
    std::vector<Bytes> buffers;      ///< by index of `buffers`, cut to byteLength; empty where there is no data
    CookContext* context = nullptr;  ///< is told what files are read; borrowed

    /// An error at a place of this file, e.g. ("accessors[3].count", "0; expected at least 1").
    [[nodiscard]] Error error(const std::string& place, const std::string& found_and_expected) const;
};

inline constexpr int kMaxJsonDepth = 64;

/// Reads the file and splits a .glb into its chunks (told by its first bytes, not by its name).
[[nodiscard]] Result<GltfFile> open_gltf(const std::filesystem::path& path, CookContext& context);

/// Fills `buffers`. The JSON's shape must have been validated.
[[nodiscard]] Status load_buffers(GltfFile& file);

/// The bytes that a URI names: base64 or percent-encoded data inside it, or a file beside the model: in its folder,
/// below it, or in a neighbouring folder (`../textures/a.png`), no further up.
/// @return bytes owned by `file`
[[nodiscard]] Result<Bytes> load_uri(GltfFile& file, const std::string& uri, const std::string& place);

}  // namespace ff::cook
