// Columns of frames, slow frames kept as they pass, and what the page refuses.

#include "tools/report/frame_series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tools/report/report.h"
#include "tools/report/worst_frames.h"

namespace ff::report {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

FrameSeries series_of(const std::vector<double>& times) {
    FrameSeries series(times.size());
    for (const double ms : times) {
        frame::FrameStats stats;
        stats.ms(frame::Pass::cast) = ms / 2.0;
        stats.rays = 10;
        series.add({.position = {1.0, 2.0, 3.0}}, ms, work_of(stats, 0, 0), stats);
    }
    return series;
}

TEST(FrameSeries, has_a_column_for_what_is_not_zero) {
    const json frames = series_of({1.0, 3.0}).to_json();
    EXPECT_EQ(frames["ms"], json({1.0, 3.0}));
    EXPECT_EQ(frames["pass_ms"], json({{"cast", {0.5, 1.5}}}));
    EXPECT_EQ(frames["work"], json({{"rays", {10, 10}}}));
    EXPECT_EQ(frames["position_m"][1], json({1.0, 2.0, 3.0}));
    EXPECT_TRUE(frames["plan"]["ray_budget"][0].is_null()) << "no bound";
}

TEST(FrameSeries, finds_the_slowest_frames_apart_from_each_other) {
    std::vector<double> times(50, 1.0);
    times[1] = 99.0;
    times[20] = 9.0;
    times[21] = 8.0;
    times[40] = 7.0;
    EXPECT_THAT(series_of(times).worst_frames(2, 4), ElementsAre(20, 40));
}

TEST(WorstFrames, keeps_the_slowest_as_they_pass) {
    WorstFrames worst(2);
    const auto pass = [&](std::size_t frame, double ms) {
        if (worst.wants(frame, ms)) worst.keep({.frame = frame, .ms = ms, .plan = {}, .image = {}});
    };
    pass(0, 5.0);
    pass(1, 6.0);  // stands for its neighbour
    pass(30, 2.0);
    pass(60, 3.0);  // pushes out the fastest
    pass(61, 1.0);
    std::vector<std::size_t> frames;
    for (const FramePicture& picture : worst.pictures()) frames.push_back(picture.frame);
    EXPECT_THAT(frames, ElementsAre(1, 60));
}

TEST(WorstFrames, of_which_none_are_asked_for_keeps_none) {
    WorstFrames none(0);
    for (std::size_t frame = 0; frame < 100; ++frame) {
        EXPECT_FALSE(none.wants(frame, double(frame)));
        none.keep({.frame = frame, .ms = double(frame), .plan = {}, .image = {}});
    }
    EXPECT_TRUE(none.pictures().empty());
}

std::string error_of(const json& data) {
    const Input input{"x.json", data.dump()};
    const auto page = make_page(std::span(&input, 1));
    return page ? "no error" : page.error().message;
}

TEST(Report, refuses_what_it_cannot_draw) {
    json run{{"kind", "replay"}, {"frames", series_of({1.0, 2.0}).to_json()}};
    EXPECT_EQ(error_of(run), "no error");
    EXPECT_THAT(error_of({{"kind", "replay"}}), HasSubstr("x.json: replay: no 'frames'"));
    EXPECT_THAT(error_of({{"kind", "else"}}), HasSubstr("expected what ff bench"));
    EXPECT_THAT(error_of(json::array()), HasSubstr("expected what ff bench"));
    run["frames"]["pass_ms"]["cast"] = {1.0};
    EXPECT_THAT(error_of(run), HasSubstr("frames.pass_ms.cast: expected 2 numbers"));
    run["frames"].erase("pass_ms");
    EXPECT_THAT(error_of(run), HasSubstr("frames.pass_ms: expected a table"));
    const Input cut{"x.json", "{\"kind\""};
    EXPECT_FALSE(make_page(std::span(&cut, 1)));
}

TEST(Report, is_not_ended_by_what_it_shows) {
    const Input input{"</script><b>.json", json{{"kind", "replay"}, {"frames", series_of({1.0}).to_json()}}.dump()};
    const auto page = make_page(std::span(&input, 1));
    ASSERT_TRUE(page);
    EXPECT_EQ(page->find("</script><b>"), std::string::npos);
}

}  // namespace
}  // namespace ff::report
