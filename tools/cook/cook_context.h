#pragma once
// What every step of a cook may use while it works: the cache, and a place for warnings and times.

#include <mutex>
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

    /// The time since the stage before ended belongs to this one. Threads: the cook's own.
    void end_stage(const char* name);
    [[nodiscard]] const std::vector<CookStage>& stages() const { return stages_; }  ///< in the order they ended

  private:
    CookCache& cache_;
    mutable std::mutex mutex_;
    std::set<std::string> warnings_;
    Stopwatch stage_;
    std::vector<CookStage> stages_;
};

}  // namespace ff::cook
