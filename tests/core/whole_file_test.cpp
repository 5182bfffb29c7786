#include "engine/core/whole_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "engine/core/write_file.h"
#include "tests/support/temporary_folder.h"

namespace ff {
namespace {

class WholeFileTest : public ::testing::Test {
  protected:
    [[nodiscard]] int entries() const {
        return int(std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
    }
    static std::vector<std::byte> bytes(std::size_t size, int value) {
        return std::vector<std::byte>(size, std::byte(value));
    }

    test::TemporaryFolder temporary;
    const std::filesystem::path& folder = temporary.path();
};

TEST_F(WholeFileTest, appears_at_its_end_alone) {
    const auto path = folder / "file";
    auto file = WholeFile::create(path);
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write(bytes(10, 'a')));
    ASSERT_TRUE(file->write(bytes(10, 'b')));
    ASSERT_TRUE(file->write_at(8, bytes(4, 'c')));
    EXPECT_FALSE(std::filesystem::exists(path));
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(read_text_file(path).value(), "aaaaaaaaccccbbbbbbbb");
    EXPECT_EQ(entries(), 1);
}

TEST_F(WholeFileTest, dropped_it_has_never_been) {
    const auto path = folder / "file";
    ASSERT_TRUE(write_file_whole(path, "before"));
    {
        auto file = WholeFile::create(path);
        ASSERT_TRUE(file);
        ASSERT_TRUE(file->write(bytes(100, 'x')));
        WholeFile moved = std::move(*file);
        ASSERT_TRUE(moved.write(bytes(100, 'y')));
    }
    EXPECT_EQ(read_text_file(path).value(), "before");
    EXPECT_EQ(entries(), 1);
}

TEST_F(WholeFileTest, says_what_is_in_the_way) {
    std::filesystem::create_directories(folder / "taken" / "by");
    const Status status = write_file_whole(folder / "taken", "text");
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("taken: cannot be replaced"), std::string::npos) << status.error().message;
    EXPECT_EQ(entries(), 1);
    EXPECT_FALSE(WholeFile::create(folder / "none" / "file"));
}

TEST_F(WholeFileTest, many_may_write_the_same_file) {
    const auto path = folder / "file";
    std::vector<pid_t> children;
    for (int c = 0; c < 4; ++c) {
        children.push_back(fork());
        if (children.back() != 0) continue;
        const auto contents = bytes(5000, 'a' + c);
        for (int i = 0; i < 200; ++i)
            if (!write_file_whole(path, contents, Flush::none)) _exit(1);
        _exit(0);
    }
    for (const pid_t child : children) {
        int status = 0;
        waitpid(child, &status, 0);
        EXPECT_EQ(status, 0);
    }
    const std::string text = read_text_file(path).value();
    EXPECT_EQ(text, std::string(5000, text[0]));
    EXPECT_EQ(entries(), 1);
}

TEST_F(WholeFileTest, killed_at_any_moment_old_or_new_is_there_and_nothing_else) {
    const auto path = folder / "file";
    ASSERT_TRUE(write_file_whole(path, std::string(200'000, 'a')));
    std::mt19937 random(3);
    for (int trial = 0; trial < 60; ++trial) {
        const pid_t child = fork();
        if (child == 0)
            for (int i = 0;; ++i)
                if (!write_file_whole(path, std::string(200'000, char('a' + i % 26)))) _exit(1);
        usleep(useconds_t(random() % 8000));
        kill(child, SIGKILL);
        int status = 0;
        waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status));
        const std::string text = read_text_file(path).value();
        ASSERT_EQ(text, std::string(200'000, text[0]));
    }
    // What a killed one left between its two names is taken away later.
    const int left = entries() - 1;
    usleep(4'000'000);
    ASSERT_TRUE(write_file_whole(path, "end"));
    EXPECT_LE(entries() - 1, std::max(0, left - 1));
}

}  // namespace
}  // namespace ff
