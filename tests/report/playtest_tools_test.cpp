// ff budget, compare and report as their users run them: a small world, files, exit codes, the page in a browser.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/e2e/browser.h"
#include "tests/e2e/run_process.h"

namespace ff::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::string kWalk = " --walk street --frames 24 --size 96x64 ";

std::string in_scratch(const std::string& name) {
    return (scratch() / name).string();
}

/// A budget that this machine made of the hamlet, with room for noise.
const std::string& budget_file() {
    static const std::string path = [] {
        const std::string file = in_scratch("hamlet.budget.toml");
        const ProcessResult made =
            run_ff("budget " + hamlet_pack().string() + kWalk + "--max-laps 3 --laps 3 --margin 900 --write " + file);
        EXPECT_EQ(made.exit_code, 0) << made.err;
        return file;
    }();
    return path;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

TEST(BudgetTest, holds_what_it_was_made_of_and_reports_it) {
    const ProcessResult result =
        run_ff("budget " + hamlet_pack().string() + kWalk + "--laps 2 --budget " + budget_file() + " --json --junit " +
               in_scratch("junit.xml") + " --trace " + in_scratch("trace.json"));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const json report = json::parse(result.out);
    EXPECT_GT(report["limits"].size(), 8u);
    for (const json& limit : report["limits"]) EXPECT_TRUE(limit["held"].get<bool>()) << limit;
    EXPECT_EQ(report["frames"]["count"], 24);
    EXPECT_GT(report["calibration"]["scale"], 0.0);
    const std::string junit = read_file(in_scratch("junit.xml"));
    EXPECT_THAT(junit, HasSubstr("failures=\"0\""));
    EXPECT_THAT(junit, HasSubstr("<testcase classname=\"hamlet, walk street\" name=\"time.median_ms\""));
    EXPECT_GT(json::parse(read_file(in_scratch("trace.json"))).at("traceEvents").size(), 24u * 5u);
}

TEST(BudgetTest, work_is_the_same_for_any_number_of_workers) {
    const std::string one = " --laps 1 --threads 1 --json --budget " + budget_file();
    const std::string two = " --laps 2 --threads 2 --json --budget " + budget_file();
    const json a = json::parse(run_ff("budget " + hamlet_pack().string() + kWalk + one).out);
    const json b = json::parse(run_ff("budget " + hamlet_pack().string() + kWalk + two).out);
    for (const char* key : {"work.rays", "work.triangles", "work.points", "work.texels", "work.pixels", "work.layers"})
        EXPECT_EQ(a["figures"][key], b["figures"][key]) << key;
}

TEST(BudgetTest, a_miss_ends_with_4_and_keeps_the_frame) {
    const std::string strict = in_scratch("strict.toml");
    write_file(strict, "format = 1\n[work]\nrays = 1\n");
    std::filesystem::create_directories(scratch() / "ci");
    const ProcessResult missed = run_ff("budget " + hamlet_pack().string() + kWalk + "--laps 1 --budget " + strict +
                                        " --junit " + in_scratch("ci/junit.xml"));
    EXPECT_EQ(missed.exit_code, 4);
    EXPECT_THAT(missed.err, HasSubstr("1 of 1 limits missed, worst work.rays: "));
    EXPECT_THAT(missed.err, HasSubstr("worst in frame "));
    EXPECT_THAT(missed.err, HasSubstr("ci/budget-miss"));
    const auto folder = scratch() / "ci" / "budget-miss";
    EXPECT_TRUE(std::filesystem::exists(folder / "frame.png"));
    EXPECT_THAT(read_file(folder / "plan.txt"), HasSubstr("mode hybrid"));
    EXPECT_FALSE(json::parse(read_file(folder / "trace.json")).at("traceEvents").empty());
    EXPECT_FALSE(json::parse(read_file(folder / "budget.json")).at("limits")[0]["held"].get<bool>());
    EXPECT_THAT(read_file(scratch() / "ci" / "junit.xml"), HasSubstr("<failure type=\"limit\""));
}

TEST(BudgetTest, refuses_what_cannot_be) {
    const std::string pack = hamlet_pack().string();
    EXPECT_EQ(run_ff("budget " + pack).exit_code, 2);
    EXPECT_EQ(run_ff("budget " + pack + " --budget no_such.toml").exit_code, 3);
    EXPECT_EQ(run_ff("budget " + pack + " --frames 3 --budget " + budget_file()).exit_code, 2);
    const std::string wrong = in_scratch("wrong.toml");
    write_file(wrong, replaced(read_file(budget_file()), "median_ms", "medium_ms"));
    const ProcessResult result = run_ff("budget " + pack + " --budget " + wrong);
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_THAT(result.err, HasSubstr("wrong.toml:"));
    EXPECT_THAT(result.err, HasSubstr("'medium_ms' is unknown; expected median_ms"));
}

TEST(ReportTest, its_page_draws_and_its_controls_work_in_a_browser) {
    if (run("command -v chromium").exit_code != 0) GTEST_SKIP() << "no chromium here (tools/setup installs it)";
    const std::string pack = hamlet_pack().string();
    const ProcessResult bench = run_ff("bench " + pack + kWalk + "--modes hybrid,raycast --laps 1 --each-frame");
    ASSERT_EQ(bench.exit_code, 0) << bench.err;
    write_file(in_scratch("bench.json"), bench.out);
    // One limit that is missed, so that the page has one to show.
    const std::string strict = in_scratch("one_missed.toml");
    write_file(strict, replaced(read_file(budget_file()), "rays = ", "rays = 1 #"));
    const ProcessResult missed =
        run_ff("budget " + pack + kWalk + "--laps 2 --budget " + strict + " --json --keep " + in_scratch("miss"));
    ASSERT_EQ(missed.exit_code, 4) << missed.err;
    write_file(in_scratch("budget.json"), missed.out);
    const ProcessResult played =
        run_ff("play " + pack + " --player random --minutes 0.05 --recording " + in_scratch("session.ffreplay"));
    ASSERT_EQ(played.exit_code, 0) << played.err;
    for (const char* how : {"", " --each-frame --json"}) {
        const ProcessResult drawn =
            run_ff("replay " + in_scratch("session.ffreplay") + " --pack " + pack + " --bench --size 96x64" + how);
        EXPECT_EQ(drawn.exit_code, 0) << how << drawn.err;
    }
    const ProcessResult compared = run_ff("compare " + in_scratch("session.ffreplay") + " --packs " + pack + " " +
                                          pack + " --size 96x64 --json --out " + in_scratch("compare"));
    ASSERT_EQ(compared.exit_code, 0) << compared.err;
    const json comparison = json::parse(compared.out);
    EXPECT_EQ(comparison["image"]["psnr_db_min"], 99.0) << "one world is like itself";
    EXPECT_TRUE(comparison["parted_tick"].is_null());
    EXPECT_TRUE(std::filesystem::exists(scratch() / "compare" / "difference.png"));
    write_file(in_scratch("compare.json"), compared.out);

    const ProcessResult made = run_ff("report " + in_scratch("bench.json") + " " + in_scratch("budget.json") + " " +
                                      in_scratch("compare.json") + " -o " + in_scratch("report.html"));
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const PageCheck check = check_page(read_file(in_scratch("report.html")), read_file(FF_PAGE_CHECK), scratch());
    EXPECT_EQ(check.title, "all controls work") << check.log.substr(0, 2000);
    EXPECT_EQ(check.log.find("CONSOLE"), std::string::npos) << check.log.substr(check.log.find("CONSOLE"), 500);
}

TEST(ReportTest, refuses_what_it_cannot_draw) {
    write_file(in_scratch("no.json"), "{\"kind\": \"bench\"");
    const ProcessResult result = run_ff("report " + in_scratch("no.json") + " -o " + in_scratch("no.html"));
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_THAT(result.err, HasSubstr("no.json"));
    EXPECT_EQ(run_ff("report").exit_code, 2);
}

TEST(CompareTest, refuses_what_cannot_be) {
    EXPECT_EQ(run_ff("compare").exit_code, 2);
    EXPECT_EQ(run_ff("compare no_such.ffreplay --packs a b").exit_code, 3);
}

}  // namespace
}  // namespace ff::test
