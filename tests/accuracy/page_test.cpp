// ff accuracy as its users run it: a small scene, its files, its page in a headless browser, and its table in use.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/e2e/browser.h"
#include "tests/e2e/run_process.h"

namespace ff::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// The report of the hamlet, made once.
const std::filesystem::path& report() {
    static const std::filesystem::path folder = [] {
        const auto out = scratch() / "accuracy";
        const ProcessResult result =
            run_ff("accuracy " + hamlet_pack().string() + " --quick --size 64x48 --out " + out.string());
        EXPECT_EQ(result.exit_code, 0) << result.err;
        EXPECT_THAT(result.err, HasSubstr("accuracy.html"));
        return out;
    }();
    return folder;
}

TEST(AccuracyTest, writes_every_knob_s_points_and_the_front) {
    const json table = json::parse(read_file(report() / "accuracy.json"));
    EXPECT_GE(table.at("knobs").size(), 10u);
    for (const json& knob : table.at("knobs")) {
        EXPECT_GE(knob.at("points").size(), 2u) << knob.at("name");
        for (const json& p : knob.at("points"))
            for (const char* key : {"value", "frame_ms_median", "frame_ms_p99", "psnr_db", "ssim", "flip_mean",
                                    "wrong_pixels_pct", "flicker"})
                EXPECT_TRUE(p.at(key).is_number()) << knob.at("name") << ' ' << key;
    }
    EXPECT_GE(table.at("pareto").size(), 1u);
    for (const json& p : table.at("pareto")) EXPECT_TRUE(p.at("settings").is_object());
}

TEST(AccuracyTest, its_page_draws_and_its_controls_work_in_a_browser) {
    if (run("command -v chromium").exit_code != 0) GTEST_SKIP() << "no chromium here (tools/setup installs it)";
    const PageCheck check = check_page(read_file(report() / "accuracy.html"), read_file(FF_PAGE_CHECK), scratch());
    EXPECT_EQ(check.title, "all controls work") << check.log.substr(0, 2000);
    EXPECT_EQ(check.log.find("CONSOLE"), std::string::npos) << check.log.substr(check.log.find("CONSOLE"), 500);
}

TEST(AccuracyTest, an_allowed_error_picks_settings_from_the_table_and_says_so) {
    (void)report();
    const std::string pack = hamlet_pack().string();
    const ProcessResult picked =
        run_ff("walk " + pack + " --headless --size 64x48 --min-psnr 15 --out " + (scratch() / "picked").string());
    EXPECT_EQ(picked.exit_code, 0) << picked.err;
    EXPECT_THAT(picked.err, HasSubstr("settings: "));
    EXPECT_THAT(picked.err, HasSubstr("15 dB or more"));
    // Another pack has no table.
    const auto other = scratch() / "other.ffpack";
    std::filesystem::copy_file(hamlet_pack(), other);
    const ProcessResult refused = run_ff("bench " + other.string() + " --max-error-px 1");
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_THAT(refused.err, HasSubstr("ff accuracy"));
}

TEST(AccuracyTest, refuses_what_cannot_be) {
    EXPECT_EQ(run_ff("accuracy").exit_code, 2);
    EXPECT_EQ(run_ff("accuracy no_such.ffpack").exit_code, 3);
    const auto file = scratch() / "a_file";
    write_file(file, "x");
    const ProcessResult result =
        run_ff("accuracy " + hamlet_pack().string() + " --quick --size 16x16 --out " + (file / "below").string());
    EXPECT_NE(result.exit_code, 0);
    EXPECT_THAT(result.err, HasSubstr("a_file"));
}

}  // namespace
}  // namespace ff::test
