#include "tests/hardcases/hard_case.h"

#include <fmt/format.h>

#include <ctime>

namespace ff::hardcases {

double Trial::processor_seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

std::string Trial::seed_note() const {
    return fmt::format(" (--seed {} makes it in the first round)", round_seed_);
}

Outcome Trial::outcome() const {
    Outcome outcome = outcome_;
    if (easy_s_ > 0.0) outcome.time_ratio = hard_s_ / easy_s_;
    return outcome;
}

Outcome run_case(const HardCase& hard_case, std::uint64_t instances, std::uint32_t seed, Progress* progress) {
    Trial trial(instances == 0 ? hard_case.instances : instances, seed, progress);
    hard_case.run(trial);
    return trial.outcome();
}

std::string broken_bound(const HardCase& hard_case, const Outcome& outcome, bool with_time) {
    if (!outcome.skipped.empty()) return {};
    if (double(outcome.failures) > hard_case.max_failure_rate * double(outcome.instances))
        return fmt::format("{} failures of {}, more than {:g} of them: {}", outcome.failures, outcome.instances,
                           hard_case.max_failure_rate, outcome.first_failure);
    if (!(outcome.worst_error <= hard_case.max_worst_error))
        return fmt::format("an error of {:.3g} {}, more than {:g}", outcome.worst_error, hard_case.unit,
                           hard_case.max_worst_error);
    if (with_time && hard_case.max_time_ratio > 0.0 && outcome.time_ratio > hard_case.max_time_ratio)
        return fmt::format("{:.2f} times the time of the easy case, more than {:g}", outcome.time_ratio,
                           hard_case.max_time_ratio);
    return {};
}

}  // namespace ff::hardcases
