#include "engine/core/work_clock.h"

#include <time.h>

#include <atomic>

namespace ff {
namespace {
std::atomic<WorkClock> g_clock{WorkClock::wall};
}

void set_work_clock(WorkClock clock) {
    g_clock.store(clock, std::memory_order_relaxed);
}

WorkClock work_clock() {
    return g_clock.load(std::memory_order_relaxed);
}

std::int64_t work_ns() {
    if (work_clock() == WorkClock::wall) return steady_ns();
    timespec ran{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &ran);
    return std::int64_t(ran.tv_sec) * 1'000'000'000 + ran.tv_nsec;
}

}  // namespace ff
