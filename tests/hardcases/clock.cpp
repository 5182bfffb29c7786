// Thirty days of frames through the fixed step: no tick is gained or lost, whatever the clock does.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/loop/fixed_step.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr std::int64_t kMsNs = 1'000'000, kSecondNs = 1000 * kMsNs;

/// Time between two frames of a window of about 60 Hz; now and then none, some of it back, or ten seconds at once.
std::int64_t frame_ns(test::Random& random) {
    const std::uint32_t kind = random.below(10000);
    if (kind == 0) return 10 * kSecondNs;
    if (kind < 100) return 0;
    if (kind < 200) return -std::int64_t(random.below(3600)) * kSecondNs;
    return 16 * kMsNs + std::int64_t(random.below(std::uint32_t(1'360'000)));
}

}  // namespace

void clock_ticks(Trial& trial) {
    constexpr std::uint32_t kRates[] = {30, 60, 72, 90, 120, 144, 1000};
    constexpr int kFramesPerRound = 100000;
    test::Random first(trial.next_seed());
    const auto rate = int(kRates[first.below(7)]), max_ticks = std::max(1, rate / 10);
    loop::FixedStep step({.ticks_per_second = rate, .max_ticks = max_ticks});
    Wide elapsed_ns = 0;  // all time that ran forwards
    std::uint64_t before = 0;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        for (int frame = 0; frame < kFramesPerRound; ++frame) {
            const std::int64_t dt = frame_ns(random);
            const int ticks = step.advance(dt);
            elapsed_ns += std::uint64_t(std::max<std::int64_t>(0, dt));
            const auto due = std::uint64_t(elapsed_ns * unsigned(rate) / unsigned(kSecondNs));
            const std::uint64_t accounted = step.ticks() + step.dropped_ticks();
            const bool keeps_limit = ticks >= 0 && ticks <= max_ticks &&
                                     std::uint64_t(ticks) == std::min(due - before, std::uint64_t(max_ticks));
            const bool is_fraction = step.fraction() >= 0.0 && step.fraction() < 1.0;
            before = due;
            trial.count(keeps_limit && is_fraction, std::fabs(double(accounted) - double(due)),
                        [&] { return fmt::format("{} ticks for {} ns, {} of {} in all", ticks, dt, accounted, due); });
        }
        trial.report();
    }
}

}  // namespace ff::hardcases
