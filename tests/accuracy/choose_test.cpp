#include "tools/accuracy/choose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"

namespace ff::accuracy {
namespace {

using nlohmann::json;
using testing::HasSubstr;

json measured(double ratio, double displacement_px, double psnr_db) {
    return {{"frame_ms_median", 20.0 * ratio},
            {"exact_frame_ms_median", 20.0},
            {"displacement_px", displacement_px},
            {"psnr_exact_db_min", psnr_db}};
}

class ChooseTest : public testing::Test {
  protected:
    ChooseTest() {
        json coarse = measured(0.5, 1.0, 28.0), coarser = measured(0.3, 2.0, 25.0), slow = measured(1.4, 0.0, 60.0);
        coarse["value"] = 0.5;
        coarser["value"] = 0.35;
        slow["value"] = 1.0;
        json pair = measured(0.25, 1.0, 27.0);
        pair["settings"] = {{"resolution", 0.5}, {"prelit_beyond", 100.0}};
        table_ = {{"scene", {{"walk", "street"}, {"pack_hash", "00000000000000ab"}}},
                  {"knobs",
                   {{{"name", "resolution"}, {"points", {coarse, coarser}}}, {{"name", "caster"}, {"points", {slow}}}}},
                  {"pairs", {pair}}};
        write(table_.dump());
    }

    void write(const std::string& text) const { std::ofstream(table_path(pack_)) << text; }
    Result<std::string> choose(const Limits& limits) {
        settings_ = {};
        return choose_settings(pack_, 0xab, "street", limits, settings_);
    }

    test::TemporaryFolder folder_;
    std::filesystem::path pack_ = folder_ / "world.ffpack";
    json table_;
    frame::FrameSettings settings_;
};

TEST_F(ChooseTest, takes_the_fastest_that_keeps_the_limits) {
    ASSERT_TRUE(choose({.min_psnr_db = 27.5}));
    EXPECT_FLOAT_EQ(settings_.resolution, 0.5f);
    EXPECT_FALSE(std::isfinite(settings_.prelit_beyond_m));
    const auto pair = choose({.max_displacement_px = 1.0});
    ASSERT_TRUE(pair);
    EXPECT_FLOAT_EQ(settings_.resolution, 0.5f);
    EXPECT_FLOAT_EQ(settings_.prelit_beyond_m, 100.0f);
    EXPECT_THAT(*pair, HasSubstr("3 of 4"));
    EXPECT_THAT(*pair, HasSubstr("0.25 of an exact frame's time"));
}

TEST_F(ChooseTest, stays_exact_where_nothing_faster_keeps_them) {
    const auto said = choose({.min_psnr_db = 50.0});
    ASSERT_TRUE(said);
    EXPECT_EQ(settings_, frame::FrameSettings{});
    EXPECT_THAT(*said, HasSubstr("exact frames"));
}

TEST_F(ChooseTest, takes_no_time_for_faster_that_the_usual_settings_took_themselves) {
    json lucky = measured(0.1, 0.0, 60.0);
    lucky["value"] = 0.0;  // the usual caster
    table_["knobs"][1]["points"].push_back(lucky);
    write(table_.dump());
    ASSERT_TRUE(choose({.min_psnr_db = 27.5}));
    EXPECT_FLOAT_EQ(settings_.resolution, 0.5f);
}

TEST_F(ChooseTest, refuses_tables_that_are_not_this_pack_s) {
    table_["scene"]["pack_hash"] = "00000000000000ac";
    write(table_.dump());
    const auto other = choose({.min_psnr_db = 20.0});
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().kind, ErrorKind::bad_input);
    EXPECT_THAT(other.error().message, HasSubstr("another pack"));
    write("{\"scene\": 3");
    EXPECT_FALSE(choose({}));
    table_["scene"]["pack_hash"] = "00000000000000ab";
    table_["knobs"][0]["points"][0].erase("psnr_exact_db_min");
    write(table_.dump());
    EXPECT_FALSE(choose({}));
    std::filesystem::remove(table_path(pack_));
    const auto none = choose({});
    ASSERT_FALSE(none);
    EXPECT_THAT(none.error().message, HasSubstr("ff accuracy"));
}

TEST_F(ChooseTest, says_when_another_walk_was_measured) {
    const auto said = choose_settings(pack_, 0xab, "turn", {.min_psnr_db = 20.0}, settings_);
    ASSERT_TRUE(said);
    EXPECT_THAT(*said, HasSubstr("says little about walk turn"));
}

}  // namespace
}  // namespace ff::accuracy
