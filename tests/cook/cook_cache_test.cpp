#include "tools/cook/cook_cache.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/cook/gltf_builder.h"

namespace ff::test {
namespace {

using cook::CacheKey;
using cook::CookCache;

std::vector<std::byte> bytes_of(std::size_t count, int value) {
    return std::vector<std::byte>(count, static_cast<std::byte>(value));
}

TEST(CookCacheTest, gives_back_what_was_stored_and_nothing_else) {
    const TemporaryFolder folder;
    CookCache cache(folder / "cache");
    EXPECT_FALSE(cache.find(CacheKey("step").add("a")));
    cache.store(CacheKey("step").add("a"), bytes_of(1000, 7));
    EXPECT_EQ(cache.find(CacheKey("step").add("a")), bytes_of(1000, 7));
    EXPECT_FALSE(cache.find(CacheKey("step").add("b")));
    EXPECT_FALSE(cache.find(CacheKey("step 2").add("a")));
    EXPECT_EQ(cache.hits(), 1u);
    EXPECT_EQ(cache.misses(), 3u);
    EXPECT_EQ(cache.failed_stores(), 0u);
}

TEST(CookCacheTest, parts_of_a_key_do_not_run_into_each_other) {
    EXPECT_NE(CacheKey("s").add("ab").add("c").hex(), CacheKey("s").add("a").add("bc").hex());
    EXPECT_NE(CacheKey("s").add("").add("a").hex(), CacheKey("s").add("a").add("").hex());
    EXPECT_EQ(CacheKey("s").add("a").hex(), CacheKey("s").add("a").hex());
}

TEST(CookCacheTest, a_damaged_or_cut_entry_is_a_miss) {
    const TemporaryFolder folder;
    CookCache cache(folder / "cache");
    const CacheKey key = CacheKey("step").add("a");
    cache.store(key, bytes_of(100, 1));
    const std::filesystem::path entry = folder / "cache" / key.hex().substr(0, 2) / key.hex().substr(2);
    ASSERT_TRUE(std::filesystem::exists(entry));
    const auto size = std::filesystem::file_size(entry);
    for (std::size_t at = 0; at < size; at += 3) {
        std::fstream file(entry, std::ios::in | std::ios::out | std::ios::binary);
        file.seekg(static_cast<std::streamoff>(at));
        const char old = static_cast<char>(file.get());
        file.seekp(static_cast<std::streamoff>(at));
        file.put(static_cast<char>(old ^ 0x10));
        file.close();
        EXPECT_FALSE(cache.find(key)) << at;
        cache.store(key, bytes_of(100, 1));
        EXPECT_TRUE(cache.find(key));
    }
    std::filesystem::resize_file(entry, size - 1);
    EXPECT_FALSE(cache.find(key));
    std::filesystem::resize_file(entry, 0);
    EXPECT_FALSE(cache.find(key));
}

TEST(CookCacheTest, trimming_removes_what_was_not_used_for_longest) {
    const TemporaryFolder folder;
    CookCache cache(folder / "cache", 2500);
    for (int i = 0; i < 4; ++i) {
        const CacheKey key = CacheKey("step").add_value(i);
        cache.store(key, bytes_of(1000, i));
        const auto entry = folder / "cache" / key.hex().substr(0, 2) / key.hex().substr(2);
        std::filesystem::last_write_time(entry,
                                         std::filesystem::file_time_type::clock::now() - std::chrono::hours(9 - i));
    }
    EXPECT_TRUE(cache.find(CacheKey("step").add_value(0)));  // used just now
    cache.trim();
    EXPECT_TRUE(cache.find(CacheKey("step").add_value(0)));
    EXPECT_FALSE(cache.find(CacheKey("step").add_value(1)));
    EXPECT_FALSE(cache.find(CacheKey("step").add_value(2)));
    EXPECT_TRUE(cache.find(CacheKey("step").add_value(3)));
}

TEST(CookCacheTest, a_cache_that_cannot_be_written_only_misses) {
    CookCache none;
    none.store(CacheKey("step"), bytes_of(10, 1));
    EXPECT_FALSE(none.find(CacheKey("step")));
    CookCache bad("/proc/no-such-place");
    bad.store(CacheKey("step"), bytes_of(10, 1));
    EXPECT_FALSE(bad.find(CacheKey("step")));
    EXPECT_EQ(bad.failed_stores(), 1u);
    bad.trim();
}

}  // namespace
}  // namespace ff::test
