// Every hard case with fewer instances than `ff hardcases` gives it; a test per case, named as the case is.

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "tests/hardcases/hard_case.h"

namespace ff::hardcases {

/// GoogleTest would list its bytes.
static void PrintTo(const HardCase& hard_case, std::ostream* out) {
    *out << hard_case.name;
}

namespace {

constexpr std::uint32_t kSeed = 1;

class HardCases : public testing::TestWithParam<HardCase> {};

TEST_P(HardCases, keep_their_bounds) {
    const HardCase& hard_case = GetParam();
    const Outcome outcome = run_case(hard_case, hard_case.instances / 50, kSeed);
    if (!outcome.skipped.empty()) GTEST_SKIP() << outcome.skipped;
    fmt::print(stderr, "seed {}: {} instances, {} failures, worst error {:.3g} {}\n", kSeed, outcome.instances,
               outcome.failures, outcome.worst_error, hard_case.unit);
    EXPECT_EQ(broken_bound(hard_case, outcome, false), "");
}

INSTANTIATE_TEST_SUITE_P(All, HardCases, testing::ValuesIn(all_cases().begin(), all_cases().end()),
                         [](const testing::TestParamInfo<HardCase>& tested) {
                             std::string name(tested.param.name);
                             std::replace(name.begin(), name.end(), '.', '_');
                             return name;
                         });

TEST(HardCaseTable, gives_every_case_at_least_a_hundred_thousand_instances_and_a_name_of_its_own) {
    const std::span<const HardCase> cases = all_cases();
    for (std::size_t i = 0; i < cases.size(); ++i) {
        EXPECT_GE(cases[i].instances, 100000u) << cases[i].name;
        EXPECT_FALSE(cases[i].oracle.empty()) << cases[i].name;
        for (std::size_t j = 0; j < i; ++j) EXPECT_NE(cases[i].name, cases[j].name);
    }
}

TEST(HardCaseTable, a_run_is_repeatable_from_its_seed) {
    const HardCase& hard_case = all_cases().front();
    const Outcome a = run_case(hard_case, 5000, 7), b = run_case(hard_case, 5000, 7);
    EXPECT_EQ(a.instances, b.instances);
    EXPECT_EQ(a.failures, b.failures);
    EXPECT_EQ(a.worst_error, b.worst_error);
}

}  // namespace
}  // namespace ff::hardcases
