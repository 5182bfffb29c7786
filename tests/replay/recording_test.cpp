#include "engine/replay/recording.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <limits>
#include <random>

#include "engine/core/write_file.h"
#include "engine/replay/recorder.h"
#include "tests/support/temporary_folder.h"

namespace ff::replay {
namespace {

class RecordingTest : public testing::Test {
  protected:
    RecordingTest() {
        header = {.game = "test",
                  .engine_version = "1.2.3",
                  .pack = "a \"quoted\" name.ffpack",
                  .pack_hash = 0xFEDCBA9876543210ull,
                  .seed = 7,
                  .ticks_per_second = 120,
                  .settings = "fov_deg = 70\n",
                  .start = {std::byte(1), std::byte(0), std::byte(255)}};
    }

    static loop::UserCommand random_command(std::mt19937& random) {
        loop::UserCommand c;
        if (random() % 4 == 0) c.move_right = std::int8_t(random() % 255 - 127);
        if (random() % 4 == 0) c.move_ahead = std::int8_t(random() % 255 - 127);
        if (random() % 3 == 0) c.yaw_urad = std::int32_t(random());
        if (random() % 3 == 0) c.pitch_urad = std::int32_t(random() % 3'000'000) - 1'500'000;
        if (random() % 8 == 0) c.buttons = std::uint16_t(random());
        return c;
    }
    static StateDigest random_digest(std::mt19937& random) {
        StateDigest digest;
        digest.all = std::uint64_t(random()) << 32 | random();
        for (auto& lane : digest.lanes) lane = std::uint8_t(random());
        return digest;
    }
    /// What a recorder was told.
    Recording record(int ticks, bool close) {
        Recording told;
        told.header = header;
        auto recorder = Recorder::create(path, header);
        EXPECT_TRUE(recorder) << recorder.error().message;
        std::mt19937 random(unsigned(ticks) + 1);
        for (int t = 0; t < ticks; ++t) {
            told.commands.push_back(random_command(random));
            told.digests.push_back(random_digest(random));
            recorder->begin_tick(told.commands.back());
            recorder->end_tick(told.digests.back());
            if (t % 50 == 20) {
                told.markers.push_back({std::uint64_t(t + 1), "here it stutters \xC3\xA4"});
                recorder->mark(told.markers.back().comment);
            }
        }
        if (close) {
            EXPECT_TRUE(recorder->close());
        }
        told.closed = close;
        return told;
    }
    static void expect_equal(const Recording& a, const Recording& b) {
        EXPECT_EQ(a.header, b.header);
        EXPECT_EQ(a.commands, b.commands);
        EXPECT_EQ(a.digests, b.digests);
        EXPECT_EQ(a.markers, b.markers);
        EXPECT_EQ(a.closed, b.closed);
    }
    [[nodiscard]] std::vector<std::byte> bytes() const {
        const auto text = read_text_file(path);
        EXPECT_TRUE(text);
        const auto* first = reinterpret_cast<const std::byte*>(text->data());
        return {first, first + text->size()};
    }

    test::TemporaryFolder folder;
    std::filesystem::path path = folder / "session.ffreplay";
    SessionHeader header;
};

TEST_F(RecordingTest, reads_what_was_recorded) {
    for (const int ticks : {0, 1, 119, 120, 121, 1000}) {
        const Recording told = record(ticks, true);
        const auto read = load_recording(path);
        ASSERT_TRUE(read) << read.error().message;
        expect_equal(*read, told);
    }
}

TEST_F(RecordingTest, a_minute_takes_less_than_a_megabyte) {
    record(120 * 60, true);
    EXPECT_LT(std::filesystem::file_size(path), 1'000'000u);
}

TEST_F(RecordingTest, extremes_of_a_command_survive) {
    auto recorder = Recorder::create(path, header);
    ASSERT_TRUE(recorder);
    constexpr auto kLow = std::numeric_limits<std::int32_t>::min(), kHigh = std::numeric_limits<std::int32_t>::max();
    const std::vector<loop::UserCommand> commands{
        {-128, 127, kLow, kHigh, 0xFFFF}, {127, -128, kHigh, kLow, 0}, {0, 0, 0, 0, 1}};
    for (const auto& command : commands) {
        recorder->begin_tick(command);
        recorder->end_tick({});
    }
    ASSERT_TRUE(recorder->close());
    const auto read = load_recording(path);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->commands, commands);
}

TEST_F(RecordingTest, a_cut_file_is_read_up_to_its_last_whole_record) {
    const Recording told = record(300, true);
    const std::vector<std::byte> whole = bytes();
    std::size_t least = 0;
    for (std::size_t size = whole.size(); size-- > 0;) {
        const auto read = parse_recording(std::span(whole).first(size), "cut");
        if (!read) {
            EXPECT_EQ(read.error().kind, ErrorKind::bad_input);
            least = std::max(least, size + 1);
            continue;
        }
        ASSERT_GE(size, least) << "once the header is whole, every longer file can be read";
        EXPECT_FALSE(read->closed);
        ASSERT_LE(read->commands.size(), told.commands.size());
        EXPECT_TRUE(std::equal(read->commands.begin(), read->commands.end(), told.commands.begin()));
        EXPECT_TRUE(std::equal(read->digests.begin(), read->digests.end(), told.digests.begin()));
        EXPECT_GE(read->digests.size() + 1, read->commands.size());
    }
    EXPECT_LT(least, 500u) << "only what is cut within the header is refused";
}

TEST_F(RecordingTest, a_flipped_byte_is_found_before_the_next_checksum) {
    record(300, true);
    const std::vector<std::byte> whole = bytes();
    std::mt19937 random(3);
    for (int trial = 0; trial < 3000; ++trial) {
        std::vector<std::byte> damaged = whole;
        damaged[random() % damaged.size()] ^= std::byte(1 << random() % 8);
        const auto read = parse_recording(damaged, "damaged");
        // A changed length may make the rest look cut; then the session has not been closed.
        if (read) {
            EXPECT_FALSE(read->closed);
        } else {
            EXPECT_NE(read.error().message.find("damaged"), std::string::npos);
        }
    }
}

TEST_F(RecordingTest, what_a_killed_process_recorded_is_all_there) {
    std::mt19937 random(11);
    for (int trial = 0; trial < 65; ++trial) {
        const pid_t child = fork();
        if (child == 0) {
            auto recorder = Recorder::create(path, header);
            if (!recorder) _exit(1);
            for (std::uint64_t t = 0;; ++t) {
                recorder->begin_tick({.yaw_urad = std::int32_t(t)});
                recorder->end_tick({.all = t});
            }
        }
        ASSERT_GT(child, 0);
        usleep(useconds_t(2000 + random() % 20000));
        kill(child, SIGKILL);
        int status = 0;
        waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status));
        const auto read = load_recording(path);
        if (!read) {
            EXPECT_LT(std::filesystem::file_size(path), 100u) << "killed before the header was written";
            continue;
        }
        EXPECT_FALSE(read->closed);
        for (std::size_t t = 0; t < read->digests.size(); ++t) ASSERT_EQ(read->digests[t].all, t);
        for (std::size_t t = 0; t < read->commands.size(); ++t) ASSERT_EQ(read->commands[t].yaw_urad, std::int32_t(t));
    }
}

TEST_F(RecordingTest, says_what_is_wrong_with_a_file) {
    const auto message = [&](const std::string& text) {
        const auto read = parse_recording(std::as_bytes(std::span(text)), "x.ffreplay");
        return read ? std::string("fine") : read.error().message;
    };
    EXPECT_NE(message("").find("not a recording"), std::string::npos);
    EXPECT_NE(message("FFREPLAX").find("not a recording"), std::string::npos);
    EXPECT_NE(message(std::string("FFREPLAY\x09\0\0\0", 12)).find("version 9"), std::string::npos);
    EXPECT_NE(message(std::string("FFREPLAY\x01\0\0\0\xFF\xFF\xFF\x7F", 16)).find("bytes"), std::string::npos);
    EXPECT_FALSE(load_recording("/nowhere/x.ffreplay"));
    EXPECT_FALSE(Recorder::create("/proc/x/y.ffreplay", header));
}

TEST_F(RecordingTest, a_full_disk_ends_the_recording_and_says_so) {
    auto recorder = Recorder::create("/dev/full", header);
    EXPECT_FALSE(recorder);
    EXPECT_NE(recorder.error().message.find("cannot write"), std::string::npos);
}

}  // namespace
}  // namespace ff::replay
