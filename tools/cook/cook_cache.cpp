#include "tools/cook/cook_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>

#include "engine/core/hash.h"
#include "engine/core/write_file.h"

namespace ff::cook {
namespace {

constexpr std::uint64_t kEntryMagic = 0x3143484341434646ull;  // "FFCACHC1"

// What stands before the payload of an entry.
struct EntryHeader {
    std::uint64_t magic = kEntryMagic;
    std::uint64_t byte_count = 0;
    std::uint64_t payload_hash = 0;
};

}  // namespace

CacheKey& CacheKey::add(std::span<const std::byte> bytes) {
    const std::uint64_t size = bytes.size();
    hashes_.append(reinterpret_cast<const char*>(&size), sizeof size);
    hashes_ += content_hash_hex(bytes);
    return *this;
}

std::string CacheKey::hex() const {
    return content_hash_hex(std::as_bytes(std::span(hashes_.data(), hashes_.size())));
}

CookCache::CookCache(std::filesystem::path directory, std::uint64_t limit_bytes)
    : directory_(std::move(directory)), limit_bytes_(limit_bytes) {}

std::filesystem::path CookCache::default_directory() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache)
        return std::filesystem::path(cache) / "farfield" / "cook";
    if (const char* home = std::getenv("HOME"); home && *home)
        return std::filesystem::path(home) / ".cache" / "farfield" / "cook";
    return {};
}

std::filesystem::path CookCache::path_of(const CacheKey& key) const {
    const std::string hex = key.hex();
    return directory_ / hex.substr(0, 2) / hex.substr(2);
}

std::optional<std::vector<std::byte>> CookCache::find(const CacheKey& key) {
    if (!enabled()) return std::nullopt;
    const auto miss = [&]() -> std::optional<std::vector<std::byte>> {
        ++misses_;
        return std::nullopt;
    };
    const std::filesystem::path path = path_of(key);
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) return miss();
    const auto file_size = static_cast<std::uint64_t>(in.tellg());
    EntryHeader header;
    in.seekg(0);
    if (file_size < sizeof header || !in.read(reinterpret_cast<char*>(&header), sizeof header)) return miss();
    if (header.magic != kEntryMagic || header.byte_count != file_size - sizeof header) return miss();
    std::vector<std::byte> bytes(header.byte_count);
    if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) return miss();
    if (hash_bytes(bytes) != header.payload_hash) return miss();
    std::error_code ignored;  // the time of last use, for trim(); a read-only cache still serves
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now(), ignored);
    ++hits_;
    return bytes;
}

void CookCache::store(const CacheKey& key, std::span<const std::byte> bytes) {
    if (!enabled()) return;
    const EntryHeader header{.byte_count = bytes.size(), .payload_hash = hash_bytes(bytes)};
    std::vector<std::byte> entry(sizeof header + bytes.size());
    std::memcpy(entry.data(), &header, sizeof header);
    std::copy(bytes.begin(), bytes.end(), entry.begin() + sizeof header);
    const std::filesystem::path path = path_of(key);
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);
    if (error || !write_file_whole(path, entry, Flush::none)) ++failed_stores_;
}

void CookCache::trim() {
    if (!enabled()) return;
    struct Entry {
        std::filesystem::file_time_type used;
        std::uint64_t bytes;
        std::filesystem::path path;
    };
    std::vector<Entry> entries;
    std::uint64_t total = 0;
    std::error_code error;
    for (auto it = std::filesystem::recursive_directory_iterator(directory_, error);
         !error && it != std::filesystem::recursive_directory_iterator(); it.increment(error)) {
        std::error_code gone;  // another cook may trim at the same time
        if (!it->is_regular_file(gone) || gone) continue;
        const std::uint64_t bytes = it->file_size(gone);
        const auto used = it->last_write_time(gone);
        if (gone) continue;
        entries.push_back({used, bytes, it->path()});
        total += bytes;
    }
    if (total <= limit_bytes_) return;
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
    for (const Entry& entry : entries) {
        if (total <= limit_bytes_) break;
        std::filesystem::remove(entry.path, error);
        total -= entry.bytes;
    }
}

}  // namespace ff::cook
