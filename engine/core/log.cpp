#include "engine/core/log.h"

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <mutex>

namespace ff {
namespace {
std::mutex g_stderr_mutex;  // lines of different threads stay whole
}

void log_line(std::string_view level, const std::string& text) {
    const std::lock_guard lock(g_stderr_mutex);
    std::fprintf(stderr, "%.*s%s\n", static_cast<int>(level.size()), level.data(), text.c_str());
}

struct Progress::State {
    using Clock = std::chrono::steady_clock;
    std::string step;
    std::uint64_t total;
    Clock::time_point start = Clock::now();
    std::atomic<std::uint64_t> done = 0;
    std::mutex draw_mutex;
    Clock::time_point last_draw = start;
    bool drew = false;
    bool terminal = isatty(STDERR_FILENO) != 0;

    void draw() {
        const auto percent = total == 0 ? 100 : static_cast<int>(100 * done.load() / total);
        const std::lock_guard lock(g_stderr_mutex);
        if (terminal) {
            std::fprintf(stderr, "\r%-28s [", step.c_str());
            for (int i = 0; i < 40; ++i) std::fputc(i * 100 < percent * 40 ? '#' : '.', stderr);
            std::fprintf(stderr, "] %3d%%", percent);
        } else {
            std::fprintf(stderr, "%s: %d%%\n", step.c_str(), percent);
        }
        drew = true;
    }
};

Progress::Progress(std::string step, std::uint64_t total)
    : state_(new State{.step = std::move(step), .total = total}) {}

Progress::~Progress() {
    if (state_->drew) {
        state_->draw();
        if (state_->terminal) std::fputc('\n', stderr);
    }
    delete state_;
}

void Progress::advance(std::uint64_t by) {
    state_->done += by;
    const auto now = State::Clock::now();
    const std::unique_lock lock(state_->draw_mutex, std::try_to_lock);
    if (!lock) return;
    const auto wait =
        !state_->drew ? std::chrono::milliseconds(500) : std::chrono::milliseconds(state_->terminal ? 100 : 2000);
    if (now - state_->last_draw < wait) return;
    state_->last_draw = now;
    state_->draw();
}

}  // namespace ff
