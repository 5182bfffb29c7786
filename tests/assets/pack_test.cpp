#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "engine/assets/pack_format.h"
#include "engine/assets/pack_reader.h"
#include "engine/assets/pack_writer.h"
#include "engine/core/hash.h"
#include "engine/core/jobs.h"
#include "tests/support/temporary_folder.h"

namespace ff::assets {
namespace {

using Bytes = std::vector<std::byte>;

std::size_t file_count(const test::TemporaryFolder& folder) {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
}

Bytes read_all(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    Bytes bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

struct Content {
    std::vector<std::uint32_t> numbers, noise;
    std::vector<std::uint8_t> nothing;
};

/// Compressible numbers, noise that is stored as it is, and an empty chunk.
Content make_content(std::size_t count) {
    Content content;
    content.numbers.resize(count);
    for (std::size_t i = 0; i < count; ++i) content.numbers[i] = static_cast<std::uint32_t>(i / 64);
    content.noise.resize(count / 2);
    std::uint64_t state = 1;
    for (std::uint32_t& n : content.noise) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        n = static_cast<std::uint32_t>(state >> 32);
    }
    return content;
}

void write(const std::filesystem::path& path, const Content& content) {
    auto pack = PackWriter::create(path);
    ASSERT_TRUE(pack);
    ASSERT_TRUE(pack->add("numbers", std::span<const std::uint32_t>(content.numbers)));
    ASSERT_TRUE(pack->add("nothing", std::span<const std::uint8_t>(content.nothing)));
    ASSERT_TRUE(pack->add("noise", std::span<const std::uint32_t>(content.noise)));
    const auto bytes = pack->finish();
    ASSERT_TRUE(bytes);
    EXPECT_EQ(*bytes, std::filesystem::file_size(path));
}

Status read(const Bytes& bytes, Content& out) {
    FF_ASSIGN(const PackReader pack, PackReader::from_bytes("test.ffpack", bytes));
    const auto size = [&](const char* name) {
        const PackReader::Chunk* chunk = pack.find(name);
        return chunk && chunk->element_bytes == 4 ? chunk->element_count : 0;
    };
    out.numbers.resize(size("numbers"));
    out.noise.resize(size("noise"));
    if (out.numbers.empty() || out.noise.empty()) return bad_input("no such chunk");
    return pack.read(std::vector<PackReader::Target>{{"numbers", std::as_writable_bytes(std::span(out.numbers))},
                                                     {"noise", std::as_writable_bytes(std::span(out.noise))}});
}

/// Every byte of the pack is looked at: reading it fails as bad input, with the file's name.
::testing::AssertionResult is_refused(const Bytes& bytes) {
    Content out;
    const Status status = read(bytes, out);
    if (status) return ::testing::AssertionFailure() << "was read";
    if (status.error().kind != ErrorKind::bad_input || !status.error().message.starts_with("test.ffpack@"))
        return ::testing::AssertionFailure() << status.error().message;
    return ::testing::AssertionSuccess();
}

TEST(Pack, gives_back_what_was_written_over_many_blocks) {
    const test::TemporaryFolder folder;
    const Content content = make_content(3 * kBlockBytes / 4 + 12345);
    write(folder / "a.ffpack", content);
    Content out;
    const Status status = read(read_all(folder / "a.ffpack"), out);
    ASSERT_TRUE(status) << status.error().message;
    EXPECT_EQ(out.numbers, content.numbers);
    EXPECT_EQ(out.noise, content.noise);
    const auto pack = PackReader::open(folder / "a.ffpack");
    ASSERT_TRUE(pack);
    ASSERT_EQ(pack->chunks().size(), 3u);
    EXPECT_EQ(pack->find("noise")->stored_bytes, pack->find("noise")->raw_bytes()) << "noise does not compress";
    EXPECT_LT(pack->find("numbers")->stored_bytes, pack->find("numbers")->raw_bytes());
    EXPECT_EQ(pack->find("nothing")->element_count, 0u);
    EXPECT_EQ(pack->find("other"), nullptr);
}

TEST(Pack, has_the_same_bytes_for_any_number_of_workers) {
    const test::TemporaryFolder folder;
    const Content content = make_content(5 * kBlockBytes);
    {
        const WorkerLimit one(1);
        write(folder / "one.ffpack", content);
    }
    {
        const WorkerLimit two(2);
        write(folder / "two.ffpack", content);
    }
    EXPECT_TRUE(read_all(folder / "one.ffpack") == read_all(folder / "two.ffpack"));
}

TEST(Pack, cut_at_any_byte_is_refused) {
    const test::TemporaryFolder folder;
    write(folder / "a.ffpack", make_content(300));
    const Bytes whole = read_all(folder / "a.ffpack");
    for (std::size_t size = 0; size < whole.size(); ++size)
        ASSERT_TRUE(is_refused(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)))) << size;
}

TEST(Pack, with_any_byte_flipped_is_refused) {
    const test::TemporaryFolder folder;
    write(folder / "a.ffpack", make_content(300));
    Bytes bytes = read_all(folder / "a.ffpack");
    for (std::size_t i = 0; i < bytes.size(); ++i)
        for (const auto flip : {std::byte{0x01}, std::byte{0x80}, std::byte{0xFF}}) {
            bytes[i] ^= flip;
            ASSERT_TRUE(is_refused(bytes)) << "byte " << i;
            bytes[i] ^= flip;
        }
    Content out;
    EXPECT_TRUE(read(bytes, out));
}

TEST(Pack, with_bytes_added_is_refused) {
    const test::TemporaryFolder folder;
    write(folder / "a.ffpack", make_content(300));
    Bytes bytes = read_all(folder / "a.ffpack");
    for (int i = 0; i < 130; ++i) {
        bytes.push_back(std::byte{0});
        ASSERT_TRUE(is_refused(bytes));
    }
}

TEST(Pack, of_another_version_is_called_that_with_what_to_do) {
    const test::TemporaryFolder folder;
    write(folder / "a.ffpack", make_content(300));
    Bytes bytes = read_all(folder / "a.ffpack");
    for (const std::uint32_t version : {kPackVersion - 1, kPackVersion + 1}) {
        std::memcpy(bytes.data() + offsetof(PackHeader, version), &version, sizeof version);
        const auto pack = PackReader::from_bytes("old.ffpack", bytes);
        ASSERT_FALSE(pack);
        EXPECT_EQ(pack.error().kind, ErrorKind::bad_input);
        const std::string expected = "old.ffpack@8: pack version " + std::to_string(version) +
                                     "; this program reads version " + std::to_string(kPackVersion) +
                                     "; cook the world again";
        EXPECT_EQ(pack.error().message, expected);
    }
}

TEST(Pack, that_is_no_pack_or_no_file_is_refused) {
    const test::TemporaryFolder folder;
    EXPECT_FALSE(PackReader::open(folder / "nothing.ffpack"));
    EXPECT_FALSE(PackReader::open(folder / "."));
    std::ofstream(folder / "empty.ffpack").close();
    EXPECT_FALSE(PackReader::open(folder / "empty.ffpack"));
    std::ofstream(folder / "text.ffpack") << std::string(1000, 'x');
    const auto text = PackReader::open(folder / "text.ffpack");
    ASSERT_FALSE(text);
    EXPECT_EQ(text.error().kind, ErrorKind::bad_input);
}

TEST(Pack, not_finished_leaves_the_old_one_and_no_trace) {
    const test::TemporaryFolder folder;
    const Content content = make_content(300);
    write(folder / "a.ffpack", content);
    const Bytes before = read_all(folder / "a.ffpack");
    {
        auto pack = PackWriter::create(folder / "a.ffpack");
        ASSERT_TRUE(pack);
        ASSERT_TRUE(pack->add("noise", std::span<const std::uint32_t>(content.noise)));
    }
    EXPECT_TRUE(read_all(folder / "a.ffpack") == before);
    EXPECT_EQ(file_count(folder), 1u);
}

TEST(Pack, in_a_folder_that_is_not_there_cannot_be_made) {
    const auto pack = PackWriter::create("/nonexistent/folder/a.ffpack");
    ASSERT_FALSE(pack);
    EXPECT_EQ(pack.error().kind, ErrorKind::failure);
}

}  // namespace
}  // namespace ff::assets
