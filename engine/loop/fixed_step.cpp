#include "engine/loop/fixed_step.h"

#include <algorithm>

#include "engine/core/check.h"

namespace ff::loop {
namespace {
constexpr std::uint64_t kSecondNs = 1'000'000'000;
}

FixedStep::FixedStep(const FixedStepSettings& settings) : settings_(settings) {
    FF_CHECK(settings.ticks_per_second >= 1 && settings.ticks_per_second <= 10000, "{} ticks a second",
             settings.ticks_per_second);
    FF_CHECK(settings.max_ticks >= 1 && settings.max_ticks <= 10000, "{} ticks a frame", settings.max_ticks);
}

int FixedStep::advance(std::int64_t dt_ns) {
    const auto elapsed = std::uint64_t(std::max<std::int64_t>(0, dt_ns));
    const auto rate = std::uint64_t(settings_.ticks_per_second);
    // Whole seconds apart, so that no product leaves 64 bits.
    const std::uint64_t part = elapsed % kSecondNs * rate + remainder_;
    const std::uint64_t due = elapsed / kSecondNs * rate + part / kSecondNs;
    remainder_ = part % kSecondNs;
    const std::uint64_t now = std::min(due, std::uint64_t(settings_.max_ticks));
    ticks_ += now;
    dropped_ticks_ += due - now;
    return int(now);
}

double FixedStep::fraction() const {
    return double(remainder_) / double(kSecondNs);
}

}  // namespace ff::loop
