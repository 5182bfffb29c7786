#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "engine/core/log.h"
#include "tests/hardcases/hard_case.h"
#include "tools/ff/commands.h"

namespace ff::tool {
namespace {

using hardcases::HardCase;
using hardcases::Outcome;

constexpr const char* kRow = "{:<32} {:>11} {:>9} {:>24} {:>6}  {}\n";

std::string error_text(const HardCase& hard_case, const Outcome& outcome) {
    return hard_case.unit.empty() ? "-" : fmt::format("{:.2g} {}", outcome.worst_error, hard_case.unit);
}

void print_row(const HardCase& hard_case, const Outcome& outcome) {
    if (!outcome.skipped.empty()) {
        fmt::print(kRow, hard_case.name, "skipped", "-", "-", "-", outcome.skipped);
        return;
    }
    const std::string time = outcome.time_ratio > 0.0 ? fmt::format("{:.2f}", outcome.time_ratio) : "-";
    fmt::print(kRow, hard_case.name, outcome.instances, outcome.failures, error_text(hard_case, outcome), time,
               hard_case.oracle);
    std::fflush(stdout);
}

nlohmann::json to_json(const HardCase& hard_case, const Outcome& outcome) {
    nlohmann::json row{{"name", hard_case.name},
                       {"instances", outcome.instances},
                       {"oracle", hard_case.oracle},
                       {"failures", outcome.failures},
                       {"worst_error", outcome.worst_error},
                       {"error_unit", hard_case.unit},
                       {"max_failure_rate", hard_case.max_failure_rate},
                       {"max_worst_error", hard_case.max_worst_error}};
    row["time_ratio"] = outcome.time_ratio > 0.0 ? nlohmann::json(outcome.time_ratio) : nlohmann::json();
    if (hard_case.max_time_ratio > 0.0) row["max_time_ratio"] = hard_case.max_time_ratio;
    if (!outcome.first_failure.empty()) row["first_failure"] = outcome.first_failure;
    if (!outcome.skipped.empty()) row["skipped"] = outcome.skipped;
    return row;
}

/// The cases whose name is the given one or begins with it and a dot; all for an empty one.
std::vector<const HardCase*> chosen_cases(const std::string& name) {
    std::vector<const HardCase*> out;
    for (const HardCase& hard_case : hardcases::all_cases())
        if (name.empty() || hard_case.name == name || hard_case.name.starts_with(name + ".")) out.push_back(&hard_case);
    return out;
}

}  // namespace

Status run_hardcases(const HardcasesOptions& options) {
    const std::vector<const HardCase*> cases = chosen_cases(options.name);
    if (cases.empty()) {
        std::string names;
        for (const HardCase& hard_case : hardcases::all_cases()) names += fmt::format("\n  {}", hard_case.name);
        return usage_error(fmt::format("--case: no hard case is named '{}'; there are{}", options.name, names));
    }
    if (!options.json) fmt::print(kRow, "case", "instances", "failures", "worst error", "time", "oracle");
    nlohmann::json rows = nlohmann::json::array();
    std::string broken;
    for (const HardCase* hard_case : cases) {
        Outcome outcome;
        {
            Progress progress(std::string(hard_case->name),
                              options.instances == 0 ? hard_case->instances : options.instances);
            outcome = hardcases::run_case(*hard_case, options.instances, options.seed, &progress);
        }
        if (options.json)
            rows.push_back(to_json(*hard_case, outcome));
        else
            print_row(*hard_case, outcome);
        // The time of few instances is noise.
        const bool is_full = outcome.instances >= hard_case->instances;
        if (const std::string bound = hardcases::broken_bound(*hard_case, outcome, is_full); !bound.empty())
            broken += fmt::format("\n  {}: {}", hard_case->name, bound);
    }
    if (options.json) std::printf("%s\n", nlohmann::json{{"seed", options.seed}, {"cases", rows}}.dump(2).c_str());
    if (broken.empty()) return {};
    return failure(fmt::format("hard cases exceed their bounds:{}", broken));
}

}  // namespace ff::tool
