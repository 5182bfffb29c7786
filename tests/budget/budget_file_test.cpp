// Budgets as files: what is read, what is written, what is refused and how.

#include "engine/budget/budget_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ff::budget {
namespace {

using testing::HasSubstr;

constexpr std::string_view kPasses[] = {"cast", "shade"};
constexpr std::string_view kEffects[] = {"fog", "sun_shadows"};

Result<Budget> parse(std::string_view text) {
    return parse_budget(text, "town.toml", {kPasses, kEffects});
}

std::string error_of(std::string_view text) {
    const auto parsed = parse(text);
    if (parsed) return "no error";
    EXPECT_EQ(parsed.error().kind, ErrorKind::bad_input);
    return parsed.error().message;
}

constexpr const char* kTown = R"(format = 1
calibration_ms = 0.91
[time]
median_ms = 9.8
worst_ms = 15
[passes.shade]
ms = 2.5
[passes.cast]
ms = 4.1
[effects.sun_shadows]
ms = 1.2
[work]
rays = 290000
allocations = 0
)";

TEST(BudgetFile, is_read_in_its_own_order) {
    const auto budget = parse(kTown);
    ASSERT_TRUE(budget) << budget.error().message;
    EXPECT_EQ(budget->calibration_ms, 0.91);
    std::vector<std::string> names;
    for (const Limit& limit : budget->limits) names.push_back(limit.name());
    EXPECT_THAT(names, testing::ElementsAre("time.median_ms", "time.worst_ms", "passes.shade.ms", "passes.cast.ms",
                                            "effects.sun_shadows.ms", "work.rays", "work.allocations"));
    EXPECT_EQ(budget->limits[1].value, 15.0);
    EXPECT_EQ(budget->limits[3].line, 9);
    EXPECT_EQ(budget->limits[5].value, 290000.0);
}

TEST(BudgetFile, reads_back_what_it_writes) {
    const auto budget = parse(kTown);
    ASSERT_TRUE(budget);
    const auto again = parse(to_text(*budget, "made by a test"));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->calibration_ms, budget->calibration_ms);
    ASSERT_EQ(again->limits.size(), budget->limits.size());
    for (std::size_t i = 0; i < again->limits.size(); ++i) {
        EXPECT_EQ(again->limits[i].name(), budget->limits[i].name());
        EXPECT_EQ(again->limits[i].value, budget->limits[i].value);
    }
}

TEST(BudgetFile, says_where_and_what_it_expected) {
    EXPECT_THAT(error_of("format = 1\n[tiem]\nmedian_ms = 1\n"),
                testing::AllOf(HasSubstr("town.toml:2: 'tiem' is unknown"), HasSubstr("time, passes")));
    EXPECT_THAT(error_of("format = 1\n[time]\nmedian = 1\n"),
                testing::AllOf(HasSubstr("town.toml:3: [time]: 'median'"), HasSubstr("median_ms, p99_ms, worst_ms")));
    EXPECT_THAT(error_of("format = 1\n[work]\nbeams = 1\n"), HasSubstr("town.toml:3: [work]: 'beams'"));
    EXPECT_THAT(error_of("format = 1\n[passes.paint]\nms = 1\n"),
                testing::AllOf(HasSubstr("town.toml:2: [passes]: 'paint'"), HasSubstr("cast, shade")));
    EXPECT_THAT(error_of("format = 1\n[passes.cast]\nseconds = 1\n"), HasSubstr("town.toml:3: [passes.cast]"));
    EXPECT_THAT(error_of("format = 1\n[passes.cast]\n"), HasSubstr("with ms = NUMBER"));
    EXPECT_THAT(error_of("format = 1\n[effects]\nfog = 1\n"), HasSubstr("[effects.fog] with ms"));
    EXPECT_THAT(error_of("format = 1\n[time]\nmedian_ms = \"9\"\n"), HasSubstr("expected a number from 0"));
    EXPECT_THAT(error_of("format = 1\n[time]\nmedian_ms = -1\n"), HasSubstr("town.toml:3: time.median_ms"));
    EXPECT_THAT(error_of("format = 1\n[time]\nmedian_ms = nan\n"), HasSubstr("expected a number"));
    EXPECT_THAT(error_of("format = 1\ncalibration_ms = 0\n[time]\nworst_ms = 1\n"),
                HasSubstr("town.toml:2: calibration_ms"));
    EXPECT_THAT(error_of("format = 1\ntime = 3\n"), HasSubstr("expected a table"));
    EXPECT_THAT(error_of("format = 2\n[time]\nworst_ms = 1\n"), HasSubstr("town.toml:1: format: expected 1"));
    EXPECT_THAT(error_of("[time]\nworst_ms = 1\n"), HasSubstr("expected format = 1"));
    EXPECT_THAT(error_of("format = 1\n"), HasSubstr("nothing is limited"));
    EXPECT_THAT(error_of("format = 1\n[time\n"), HasSubstr("not TOML"));
}

}  // namespace
}  // namespace ff::budget
