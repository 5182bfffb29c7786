// What the lab makes of measurements: fronts, pairs, sentences; and a small sweep for real.

#include "tools/accuracy/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/worlds.h"
#include "tools/accuracy/report.h"

namespace ff::accuracy {
namespace {

using testing::HasSubstr;

Point point(const std::string& knob, double value, double ratio, double flip) {
    Point p;
    p.settings = {{knob, value}};
    p.times = {.median_ms = 10.0 * ratio, .p99_ms = 12.0 * ratio, .exact_median_ms = 10.0};
    p.errors.flip_mean = flip;
    p.errors.psnr_exact_db_min = 50.0 - 100.0 * flip;
    return p;
}

std::vector<const Point*> addresses(const std::vector<Point>& points) {
    std::vector<const Point*> result;
    for (const Point& p : points) result.push_back(&p);
    return result;
}

TEST(ParetoTest, keeps_what_nothing_else_beats_in_both) {
    const std::vector<Point> points{point("a", 0, 1.0, 0.01), point("a", 1, 0.5, 0.02), point("a", 2, 0.6, 0.03),
                                    point("b", 0, 0.4, 0.05), point("b", 1, 0.5, 0.04), point("b", 2, 2.0, 0.0099999)};
    const auto all = addresses(points);
    const auto front = pareto_front(all);
    ASSERT_EQ(front.size(), 3u);
    EXPECT_EQ(front[0], &points[3]);
    EXPECT_EQ(front[1], &points[1]);
    EXPECT_EQ(front[2], &points[0]);  // not the last: twice the time for nothing
}

TEST(PairsTest, joins_values_of_different_knobs_that_save_time) {
    const Point exact = point("", 0, 1.0, 0.01);
    const std::vector<Point> singles{point("a", 1, 0.5, 0.02), point("a", 2, 0.4, 0.05), point("b", 1, 0.8, 0.011),
                                     point("c", 1, 1.5, 0.0)};
    const auto pairs = promising_pairs(addresses(singles), exact, 5);
    ASSERT_EQ(pairs.size(), 2u);  // a with b, twice; c saves nothing
    for (const KnobSettings& pair : pairs) {
        ASSERT_EQ(pair.size(), 2u);
        EXPECT_EQ(pair[0].first, "a");
        EXPECT_EQ(pair[1].first, "b");
    }
}

TEST(PairsTest, counts_a_technique_once_and_pairs_it_with_nothing_that_it_ignores) {
    const Point exact = point("", 0, 1.0, 0.01);
    const std::vector<Point> singles{point("reproject_count", 5, 0.5, 0.03), point("reproject_count", 1, 0.4, 0.05),
                                     point("reproject_period", 0, 0.45, 0.04), point("horizon", 0, 0.9, 0.01),
                                     point("resolution", 0.5, 0.3, 0.06)};
    const auto pairs = promising_pairs(addresses(singles), exact, 20);
    std::vector<std::string> names;
    for (const KnobSettings& pair : pairs) names.push_back(pair[0].first + " " + pair[1].first);
    std::sort(names.begin(), names.end());
    const std::vector<std::string> expected{
        "horizon resolution",         "reproject_count reproject_period", "reproject_count reproject_period",
        "reproject_count resolution", "reproject_count resolution",       "reproject_period resolution"};
    EXPECT_EQ(names, expected);
    // Without what reprojection does by itself, nobody knows what two of its knobs do.
    const std::vector<Point> turned{singles[1], singles[2]};
    EXPECT_TRUE(promising_pairs(addresses(turned), exact, 20).empty());
}

TEST(SentenceTest, says_what_a_millisecond_costs) {
    const frame::Knob knob{.name = "resolution", .default_value = 1.0};
    const std::vector<Point> points{point("resolution", 1.0, 1.0, 0.010), point("resolution", 0.5, 0.5, 0.060)};
    const std::string text = say(knob, points);
    EXPECT_THAT(text, HasSubstr("saves 5.00 ms of 10.0"));
    EXPECT_THAT(text, HasSubstr("0.0100 FLIP"));
    const std::vector<Point> slower{point("resolution", 1.0, 1.0, 0.01), point("resolution", 0.5, 1.1, 0.02)};
    EXPECT_THAT(say(knob, slower), HasSubstr("No other value is faster"));
}

TEST(KnobTest, every_knob_s_default_is_that_of_the_settings_or_one_of_its_values) {
    for (const frame::Knob& knob : frame::knobs()) {
        frame::FrameSettings settings;
        EXPECT_TRUE(frame::set_knob(settings, knob.name, knob.default_value)) << knob.name;
        for (const frame::KnobValue& v : knob.values) {
            EXPECT_TRUE(frame::set_knob(settings, knob.name, v.value)) << knob.name << ' ' << v.value;
            EXPECT_TRUE(std::isfinite(v.value)) << knob.name << ": JSON has no infinity";
        }
    }
    frame::FrameSettings settings;
    EXPECT_FALSE(frame::set_knob(settings, "resolution", 3.0));
    EXPECT_FALSE(frame::set_knob(settings, "resolution", std::nan("")));
    EXPECT_FALSE(frame::set_knob(settings, "no_such_knob", 1.0));
}

class MeasureTest : public testing::Test {
  protected:
    MeasureTest() : world_(test::make_city({.cells = 2}), {.name = "city"}), casters_(world_.scene()) {
        for (int i = 0; i < 6; ++i)
            walk_.frames.push_back({.position = {20.0 + 0.5 * i, 40.0, 20.0}, .yaw_deg = 40.0, .pitch_deg = -10.0});
        walk_.name = "steps";
        frames_ = schedule(walk_.frames.size(), {.segments = 1, .warm_up_frames = 1, .counted_frames = 3, .laps = 1});
    }

    LabScene scene() {
        return {.world = world_,
                .walk = walk_,
                .moving = {},
                .width = 96,
                .height = 64,
                .make_renderer = [this](int width, int height) {
                    return std::make_unique<frame::Renderer>(world_.scene(), casters_, nullptr, width, height);
                }};
    }

    scene::World world_;
    frame::Casters casters_;
    scene::Walk walk_;
    std::vector<ScheduledFrame> frames_;
};

TEST_F(MeasureTest, exact_frames_are_exact_and_coarser_ones_are_worse) {
    const LabScene lab = scene();
    const auto reference = make_reference(lab, frames_, {});
    ASSERT_TRUE(reference);
    const Bench bench{.scene = lab, .frames = frames_, .reference = *reference, .laps = 1};
    const KnobSettings settings[] = {{}, {{"resolution", 0.5}}, {{"resolution", 0.35}}, {{"caster", 1.0}}};
    const auto points = measure(bench, settings, "test");
    ASSERT_TRUE(points) << points.error().message;
    EXPECT_TRUE((*points)[0].is_exact);
    EXPECT_GE((*points)[0].errors.psnr_exact_db_min, 40.0);
    EXPECT_LE((*points)[0].errors.wrong_pixels_pct, 0.1);
    EXPECT_EQ((*points)[3].errors.psnr_exact_db_min, 99.0);
    EXPECT_EQ((*points)[3].errors.wrong_pixels_pct, 0.0);
    EXPECT_GT((*points)[1].errors.flip_mean, 1.2 * (*points)[0].errors.flip_mean);
    EXPECT_GT((*points)[2].errors.flip_mean, (*points)[1].errors.flip_mean);
    EXPECT_LT((*points)[1].errors.ssim, (*points)[0].errors.ssim);
    EXPECT_GT((*points)[2].errors.wrong_pixels_pct, 1.0);
    EXPECT_GT((*points)[1].times.median_ms, 0.0);
}

TEST_F(MeasureTest, a_whole_sweep_makes_a_report) {
    const LabScene lab = scene();
    const auto reference = make_reference(lab, frames_, {});
    ASSERT_TRUE(reference);
    const Bench bench{.scene = lab, .frames = frames_, .reference = *reference, .laps = 1};
    const auto swept = sweep(bench, 2);
    ASSERT_TRUE(swept) << swept.error().message;
    std::size_t expected = 0;
    for (const frame::Knob& knob : frame::knobs())
        expected += !knob.needs_gl && !knob.needs_sun && !knob.needs_lamps && !knob.needs_mirrors &&
                    !knob.needs_water && !knob.needs_air && !knob.needs_weather && !knob.needs_wind;
    ASSERT_EQ(swept->curves.size(), expected);
    for (const KnobCurve& curve : swept->curves) {
        EXPECT_EQ(curve.points.size(), curve.knob->values.size());
        EXPECT_FALSE(curve.says.empty());
    }
    EXPECT_FALSE(swept->pareto.empty());
    const std::string json = report_json(bench, *swept, {});
    EXPECT_THAT(json, HasSubstr("\"pareto\""));
    EXPECT_THAT(json, testing::Not(HasSubstr("null")));
}

}  // namespace
}  // namespace ff::accuracy
