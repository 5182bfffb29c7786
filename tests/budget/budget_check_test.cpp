// Figures against limits, and both as JUnit.

#include "engine/budget/budget_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/budget/calibration.h"
#include "engine/budget/lap_table.h"
#include "engine/core/jobs.h"

namespace ff::budget {
namespace {

using testing::HasSubstr;

const std::vector<Figure> kFigures{{LimitKind::time, "median_ms", 10.0, 3}, {LimitKind::time, "p99_ms", 12.0, 8},
                                   {LimitKind::time, "worst_ms", 14.0, 9},  {LimitKind::pass, "cast", 5.0, 4},
                                   {LimitKind::pass, "store", 0.01, 5},     {LimitKind::work, "rays", 1000.0, 6}};

TEST(BudgetCheck, scales_times_and_not_work) {
    const Budget budget{.calibration_ms = 1.0,
                        .limits = {{LimitKind::time, "median_ms", 6.0}, {LimitKind::work, "rays", 999.0}}};
    const auto slow = check(budget, kFigures, 2.0);
    EXPECT_TRUE(slow[0].held());
    EXPECT_DOUBLE_EQ(slow[0].allowed, 12.0);
    EXPECT_FALSE(slow[1].held());
    EXPECT_EQ(slow[1].frame, 6u);
    const auto fast = check(budget, kFigures, 1.0);
    EXPECT_FALSE(fast[0].held());
    EXPECT_NEAR(fast[0].excess(), 10.0 / 6.0 - 1.0, 1e-12);
}

TEST(BudgetCheck, what_was_not_done_holds_every_limit) {
    const auto verdicts = check({.limits = {{LimitKind::effect, "fog", 0.0}}}, kFigures, 1.0);
    EXPECT_TRUE(verdicts[0].held());
    EXPECT_EQ(verdicts[0].excess(), 0.0);
}

TEST(BudgetCheck, a_limit_of_none_is_missed_by_anything) {
    const auto verdicts = check({.limits = {{LimitKind::work, "rays", 0.0}}}, kFigures, 1.0);
    EXPECT_FALSE(verdicts[0].held());
    EXPECT_GT(verdicts[0].excess(), 1e9);
}

TEST(BudgetCheck, a_made_budget_holds_what_it_was_made_of_and_catches_what_exceeds_its_margin) {
    const Budget budget = make_budget(kFigures, 0.5, 0.05);
    EXPECT_EQ(budget.calibration_ms, 0.5);
    for (const Verdict& verdict : check(budget, kFigures, 1.0)) EXPECT_TRUE(verdict.held()) << to_text(verdict);
    for (const Limit& limit : budget.limits) EXPECT_NE(limit.key, "store") << "too small to be measured";
    std::vector<Figure> slower = kFigures;
    for (Figure& figure : slower) figure.value *= 1.08;
    for (const Verdict& verdict : check(budget, slower, 1.0))
        EXPECT_EQ(verdict.held(), verdict.limit.key == "p99_ms" || verdict.limit.key == "worst_ms") << to_text(verdict);
}

TEST(BudgetCheck, junit_has_a_case_a_limit_and_escapes_names) {
    const Budget budget{.limits = {{LimitKind::time, "median_ms", 6.0}, {LimitKind::work, "rays", 5000.0}}};
    const std::string xml = to_junit(check(budget, kFigures, 1.0), "a <b> & \"c\"", 1.5);
    EXPECT_THAT(xml, HasSubstr("name=\"a &lt;b> &amp; &quot;c&quot;\" tests=\"2\" failures=\"1\""));
    EXPECT_THAT(xml, HasSubstr("<failure type=\"limit\" message=\"time.median_ms: 10.000 of 6.000 ms (+66.7 %)"));
    EXPECT_THAT(xml, HasSubstr("name=\"work.rays\""));
}

TEST(LapTable, keeps_the_least_of_a_frames_laps) {
    LapTable table(2, 1);
    for (const double value : {3.0, 1.0, 2.0}) {
        table.add_lap();
        table.at(0, 0) = value;
        table.at(1, 0) = value + 10.0;
    }
    EXPECT_EQ(table.laps(), 3u);
    EXPECT_EQ(table.least(0, 0), 1.0);
    EXPECT_EQ(table.least(1, 0), 11.0);
    EXPECT_EQ(table.sample(2, 1, 0), 12.0);
}

TEST(Calibration, does_the_same_work_whoever_does_it) {
    Calibration calibration;
    EXPECT_GT(calibration.run(), 0.0);
    const std::uint64_t checksum = calibration.checksum();
    const WorkerLimit alone(1);
    Calibration other;
    (void)other.run();
    EXPECT_EQ(other.checksum(), checksum);
    (void)other.run();
    EXPECT_EQ(other.checksum(), checksum);
}

}  // namespace
}  // namespace ff::budget
