#pragma once
// Cooking: a source (scene.toml, .gltf, .glb) to a pack that the engine maps and draws (formats.md).

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/scene/scene_data.h"
#include "tools/cook/assemble.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

struct CookSettings {
    int scale = 1;                    ///< static content this many times over, as geometry of its own. [1, 1000]
    int jobs = 0;                     ///< workers; 0: one per processor
    std::filesystem::path cache_dir;  ///< empty: CookCache::default_directory()
    bool use_cache = true;
    std::uint64_t cache_limit_bytes = 8ull << 30;
};

/// What a cook did; to_json() is `ff cook --json`.
struct CookReport {
    std::string source, pack;
    std::uint64_t triangles_stored = 0;     ///< in the pack
    std::uint64_t triangles_instanced = 0;  ///< as drawn: each instance counts
    std::uint64_t triangles_dropped = 0;    ///< degenerate
    CoincidentReport coincident;
    std::uint64_t vertices = 0, textures = 0, texels = 0, materials = 0, meshes = 0, instances = 0, cells = 0;
    std::uint64_t dynamic_instances = 0;
    std::uint64_t bytes_in = 0, bytes_out = 0;
    std::uint64_t cache_hits = 0, cache_misses = 0;
    double seconds = 0;
    std::vector<std::string> inputs;  ///< the source files read, sorted
    std::vector<CookStage> stages;
    std::vector<std::string> warnings;

    [[nodiscard]] double megabytes_per_second() const;  ///< of bytes in and out
    [[nodiscard]] std::string to_json() const;
    [[nodiscard]] std::string to_text() const;  ///< a few lines for people
};

/// Reads a source into plain arrays. A bare model gets the default environment and a spawn point by rule.
/// @param scale  see CookSettings; a scene.toml interprets it itself
[[nodiscard]] Result<WorldSource> load_source(const std::filesystem::path& source, int scale, CookContext& context);

/// Cooks source to out. What stood at out stays there on any error.
[[nodiscard]] Result<CookReport> cook(const std::filesystem::path& source, const std::filesystem::path& out,
                                      const CookSettings& settings);

}  // namespace ff::cook
