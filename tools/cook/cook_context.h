#pragma once
// What every importer may use while it works: the cache, and a place for warnings.

#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "tools/cook/cook_cache.h"

namespace ff::cook {

class CookContext {
  public:
    explicit CookContext(CookCache& cache) : cache_(cache) {}

    [[nodiscard]] CookCache& cache() { return cache_; }

    /// Keeps and prints a message, each text once. Threads: any.
    void warn(const std::string& text);
    [[nodiscard]] std::vector<std::string> warnings() const;  ///< sorted: the same for any number of workers

  private:
    CookCache& cache_;
    mutable std::mutex mutex_;
    std::set<std::string> warnings_;
};

}  // namespace ff::cook
