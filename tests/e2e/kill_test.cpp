// kill -9 at random moments of cooking: the pack that was there is still whole, and cooking again makes the same.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <random>

#include "tests/e2e/run_process.h"

namespace ff::test {
namespace {

std::string hamlet_source() {
    return std::string(FF_SOURCE_DIR) + "/tests/content/hamlet/hamlet.toml";
}

TEST(Kill, a_pack_survives_a_cook_that_is_killed_at_any_moment) {
    constexpr int kMoments = 70;
    const auto pack = scratch() / "kept.ffpack", cache = scratch() / "cache";
    const std::string cook = "XDG_CACHE_HOME=" + cache.string() + " exec " FF_BINARY " cook " + hamlet_source() +
                             " -o " + pack.string() + " >/dev/null 2>&1";
    const auto before = std::chrono::steady_clock::now();
    ASSERT_EQ(run(cook).exit_code, 0);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
    const std::string whole = read_file(pack);
    ASSERT_FALSE(whole.empty());

    std::mt19937 random(5);
    int killed = 0;
    for (int i = 0; i < kMoments; ++i) {
        // Every third time all is prepared anew, else little is, and the pack's writing is more of it.
        if (i % 3 == 0) std::filesystem::remove_all(cache);
        const double moment = std::uniform_real_distribution(0.0, (i % 3 == 0 ? 1.0 : 0.6) * took.count())(random);
        const pid_t child = fork();
        if (child == 0) {
            execl("/bin/sh", "sh", "-c", cook.c_str(), nullptr);
            _exit(127);
        }
        ASSERT_GT(child, 0);
        usleep(useconds_t(1e6 * moment));
        kill(child, SIGKILL);
        int status = 0;
        waitpid(child, &status, 0);
        killed += WIFSIGNALED(status) ? 1 : 0;
        ASSERT_EQ(read_file(pack), whole) << "killed after " << moment << " s";
    }
    EXPECT_GT(killed, kMoments / 2) << "most cooks had ended before they were killed";
    usleep(4'000'000);  // what was left between two names is taken away by those who come later
    ASSERT_EQ(run(cook).exit_code, 0) << "what was left behind is in the way";
    EXPECT_EQ(read_file(pack), whole);
    EXPECT_EQ(run_ff("info " + pack.string()).exit_code, 0);
    // What the killed ones were writing does not stay behind.
    int parts = 0;
    for (const auto& entry : std::filesystem::directory_iterator(scratch()))
        parts += entry.path().string().find(".part") != std::string::npos ? 1 : 0;
    EXPECT_LE(parts, 1);
}

}  // namespace
}  // namespace ff::test
