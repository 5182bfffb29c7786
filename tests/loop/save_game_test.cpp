#include "engine/loop/save_game.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <random>

#include "engine/core/write_file.h"
#include "tests/support/temporary_folder.h"

namespace ff::loop {
namespace {

class SaveGameTest : public testing::Test {
  protected:
    static SavedGame save_of(std::uint8_t value, std::size_t size = 1000) {
        return {"beacons", 3, std::vector<std::byte>(size, std::byte(value))};
    }

    test::TemporaryFolder temporary;
    std::filesystem::path folder = temporary / "saves", path = folder / "slot1.save";
};

TEST_F(SaveGameTest, reads_what_was_written_and_keeps_the_one_before) {
    ASSERT_TRUE(write_save(path, save_of(1)));
    ASSERT_TRUE(write_save(path, save_of(2, 0)));
    const auto now = load_save(path, "beacons", 3);
    ASSERT_TRUE(now) << now.error().message;
    EXPECT_EQ(now->save, save_of(2, 0));
    EXPECT_EQ(now->warning, "");
    EXPECT_EQ(*read_save(previous_save(path), "beacons", 3), save_of(1));
}

TEST_F(SaveGameTest, a_damaged_one_is_refused_and_the_one_before_loads) {
    ASSERT_TRUE(write_save(path, save_of(1)));
    ASSERT_TRUE(write_save(path, save_of(2)));
    const std::string whole = *read_text_file(path);
    std::mt19937 random(1);
    for (int trial = 0; trial < 300; ++trial) {
        std::string damaged = whole;
        if (trial % 2 == 0)
            damaged[random() % damaged.size()] ^= char(1 << random() % 8);
        else
            damaged.resize(random() % damaged.size());
        ASSERT_TRUE(write_file_whole(path, damaged));
        EXPECT_FALSE(read_save(path, "beacons", 3));
        const auto loaded = load_save(path, "beacons", 3);
        ASSERT_TRUE(loaded) << loaded.error().message;
        EXPECT_EQ(loaded->save, save_of(1));
        EXPECT_NE(loaded->warning.find("slot1.save"), std::string::npos);
    }
}

TEST_F(SaveGameTest, versions_and_games_are_told_apart) {
    ASSERT_TRUE(write_save(path, save_of(1)));
    EXPECT_TRUE(read_save(path, "beacons", 4)) << "older ones load";
    EXPECT_NE(read_save(path, "beacons", 2).error().message.find("version 3"), std::string::npos);
    EXPECT_NE(read_save(path, "chess", 3).error().message.find("of 'beacons'"), std::string::npos);
    EXPECT_FALSE(load_save(folder / "none.save", "beacons", 3));
}

TEST_F(SaveGameTest, where_nothing_can_be_written_nothing_is_lost) {
    ASSERT_TRUE(write_save(path, save_of(1)));
    std::filesystem::create_directory(folder / "slot1.save.new");  // in the way of the new one
    std::filesystem::create_directory(folder / "slot1.save.new" / "x");
    EXPECT_FALSE(write_save(path, save_of(2)));
    EXPECT_EQ(load_save(path, "beacons", 3)->save, save_of(1));
}

TEST_F(SaveGameTest, killed_at_any_moment_a_whole_save_is_left) {
    std::mt19937 random(7);
    ASSERT_TRUE(write_save(path, save_of(0, 100'000)));
    for (int trial = 0; trial < 65; ++trial) {
        const pid_t child = fork();
        if (child == 0)
            for (std::uint8_t i = 0;; ++i)
                if (!write_save(path, save_of(i, 100'000))) _exit(1);
        usleep(useconds_t(1000 + random() % 15000));
        kill(child, SIGKILL);
        int status = 0;
        waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status));
        const auto loaded = load_save(path, "beacons", 3);
        ASSERT_TRUE(loaded) << loaded.error().message;
        EXPECT_EQ(loaded->save, save_of(std::uint8_t(loaded->save.state[0]), 100'000));
    }
}

}  // namespace
}  // namespace ff::loop
