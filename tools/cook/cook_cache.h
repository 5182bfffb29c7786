#pragma once
// The cook's memory: results of dear steps, named by the hash of everything they depend on, so that a cook redoes only
// what changed. An entry is a file, written whole, and verified by its own hash when read; a spoilt or missing entry is
// a miss, never an error.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace ff::cook {

/// Gathers what a step depends on into a content hash. Every part is added with its length, so that parts cannot run
/// into each other.
class CacheKey {
  public:
    /// @param step  name and version of the step; change the version whenever the step's output changes.
    explicit CacheKey(std::string_view step) { add(step); }
    CacheKey& add(std::span<const std::byte> bytes);
    CacheKey& add(std::string_view text) { return add(std::as_bytes(std::span(text.data(), text.size()))); }
    template <class T>
    requires std::is_trivially_copyable_v<T> CacheKey& add_value(const T& value) {  // T must have no padding
        return add(std::as_bytes(std::span(&value, 1)));
    }
    template <class T>
    requires std::is_trivially_copyable_v<T> CacheKey& add_array(const std::vector<T>& values) {
        return add(std::as_bytes(std::span(values)));
    }
    [[nodiscard]] std::string hex() const;  ///< 32 hex digits

  private:
    std::string hashes_;  ///< 40 bytes a part: its length and its 128-bit hash
};

/// Threads: find and store may be called from many at once.
class CookCache {
  public:
    /// @param directory    made when first written; empty: a cache that never holds anything.
    /// @param limit_bytes  trim() removes the entries not used for longest beyond this.
    explicit CookCache(std::filesystem::path directory = {}, std::uint64_t limit_bytes = 8ull << 30);

    /// $XDG_CACHE_HOME/farfield/cook or ~/.cache/farfield/cook; empty where neither variable is set.
    [[nodiscard]] static std::filesystem::path default_directory();

    [[nodiscard]] std::optional<std::vector<std::byte>> find(const CacheKey& key);
    /// A store that fails (disk full, no permission) is counted, not reported: the cook goes on without.
    void store(const CacheKey& key, std::span<const std::byte> bytes);
    void trim();

    [[nodiscard]] bool enabled() const { return !directory_.empty(); }
    [[nodiscard]] std::uint64_t hits() const { return hits_; }
    [[nodiscard]] std::uint64_t misses() const { return misses_; }
    [[nodiscard]] std::uint64_t failed_stores() const { return failed_stores_; }

  private:
    [[nodiscard]] std::filesystem::path path_of(const CacheKey& key) const;

    std::filesystem::path directory_;
    std::uint64_t limit_bytes_;
    std::atomic<std::uint64_t> hits_ = 0, misses_ = 0, failed_stores_ = 0;
};

}  // namespace ff::cook
