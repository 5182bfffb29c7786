#pragma once
// What every step of a cook may use while it works: the cache, and a place for warnings, times and the files read.

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/core/stopwatch.h"
#include "tools/cook/cook_cache.h"

namespace ff::cook {

/// Time that a step of the cook took.
struct CookStage {
    std::string name;
    double seconds = 0;
};

class CookContext {
  public:
    explicit CookContext(CookCache& cache) : cache_(cache) {}

    [[nodiscard]] CookCache& cache() { return cache_; }

    /// Keeps and prints a message, each text once. Threads: any.
    void warn(const std::string& text);
    [[nodiscard]] std::vector<std::string> warnings() const;  ///< sorted: the same for any number of workers

    /// A source file that the cook has read. Threads: any.
    /// @param bytes  of it; nothing: as large as the file is
    void add_input(const std::filesystem::path& path, std::optional<std::uint64_t> bytes = {});
    [[nodiscard]] std::vector<std::filesystem::path> inputs() const;  ///< sorted, each once
    [[nodiscard]] std::uint64_t bytes_in() const;                     ///< of all inputs

    /// The time since the stage before ended belongs to this one. Threads: the cook's own.
    void end_stage(const char* name);
    [[nodiscard]] const std::vector<CookStage>& stages() const { return stages_; }  ///< in the order they ended

  private:
    CookCache& cache_;
    mutable std::mutex mutex_;
    std::set<std::string> warnings_;
    std::map<std::filesystem::path, std::uint64_t> inputs_;  ///< and their sizes
    Stopwatch stage_;
    std::vector<CookStage> stages_;
};

}  // namespace ff::cook
