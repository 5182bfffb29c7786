#include "engine/frame/plan.h"

#include <gtest/gtest.h>

#include <limits>

#include "engine/frame/check_input.h"
#include "engine/frame/history.h"
#include "engine/frame/knobs.h"
#include "tests/support/worlds.h"

namespace ff::frame {
namespace {

FramePlan plan_of(const FrameSettings& settings, int frames_at_rest, double vertical_fov = Camera{}.vertical_fov) {
    const scene::SceneData data = test::make_city({.cells = 2});
    const scene::StaticScene scene = data.view();
    FrameHistory history;
    history.reset(64, 48);
    history.can_rasterise = true;
    FramePlan plan;
    for (int f = 0; f <= frames_at_rest; ++f) {
        plan_frame(scene, {}, {}, {.position = {0, 2, 0}, .vertical_fov = vertical_fov}, 64, 48, settings, history,
                   plan);
        history.has_frame = true;
        history.last_view = plan.view;
        ++history.frame_number;
    }
    return plan;
}

TEST(Plan, a_first_hybrid_frame_casts_everything_below_the_horizon_and_fills_the_panorama) {
    EXPECT_EQ(to_text(plan_of({.fixed_near_m = 0.0}, 0)),
              "mode hybrid\n"
              "near field none, 0 m\n"
              "horizon traced, every 1 azimuths\n"
              "panorama not used and filled ahead, up to 0.5 px\n"
              "rays as many as needed by beam\n");
}

TEST(Plan, a_viewer_who_rests_gets_the_panorama_filled_ahead) {
    EXPECT_EQ(to_text(plan_of({.fixed_near_m = 0.0}, 4)),
              "mode hybrid\n"
              "near field none, 0 m\n"
              "horizon traced, every 1 azimuths\n"
              "panorama looked up and filled ahead, up to 0.5 px\n"
              "rays as many as needed by beam\n");
}

TEST(Plan, accuracy_of_air_and_water_is_what_the_settings_say_and_nonsense_is_refused) {
    const scene::SceneData data = test::make_city({.cells = 1});
    const auto status_of = [&](const FrameSettings& settings) {
        return check_frame_input(data.view(), {}, {}, settings);
    };
    EXPECT_TRUE(status_of({.air_error = 0.0f, .water_within_m = 0.0f}));
    EXPECT_TRUE(status_of({.air_error = 0.1f, .water_within_m = 1e5f}));
    for (const float bad : {-0.001f, 0.11f, std::numeric_limits<float>::quiet_NaN()}) {
        const Status status = status_of({.air_error = bad});
        ASSERT_FALSE(status) << bad;
        EXPECT_NE(status.error().message.find("air_error"), std::string::npos) << status.error().message;
    }
    for (const float bad : {-1.0f, 2e5f, std::numeric_limits<float>::quiet_NaN()}) {
        const Status status = status_of({.water_within_m = bad});
        ASSERT_FALSE(status) << bad;
        EXPECT_NE(status.error().message.find("water_within_m"), std::string::npos) << status.error().message;
    }
    FrameSettings settings;
    ASSERT_TRUE(set_knob(settings, "air_error", 1.0 / 64.0));
    EXPECT_EQ(plan_of(settings, 0).air_error, 1.0f / 64.0f);
    ASSERT_TRUE(set_knob(settings, "water_within", 250.0));
    EXPECT_EQ(settings.water_within_m, 250.0f);
    for (const char* const name : {"air_error", "water_within"}) {
        FrameSettings usual;
        ASSERT_TRUE(set_knob(usual, name, find_knob(name)->default_value));
        EXPECT_EQ(usual, FrameSettings{}) << name << ": the knob's default is that of the settings";
    }
}

TEST(Plan, who_looks_through_a_spyglass_gets_no_texels_wider_than_pixels) {
    const FramePlan wide = plan_of({.fixed_near_m = 0.0}, 4, radians_of(60.0));
    EXPECT_TRUE(wide.look_up_panorama);
    // 48 rows in 0.5 degrees: a face of 2048 texels, the largest, has texels four times as wide.
    const FramePlan narrow = plan_of({.fixed_near_m = 0.0}, 4, radians_of(0.5));
    EXPECT_FALSE(narrow.look_up_panorama || narrow.fill_panorama || narrow.store_panorama);
    const FramePlan within_budget = plan_of({.budget_ms = 1000.0, .fixed_near_m = 0.0}, 4, radians_of(0.5));
    EXPECT_FALSE(within_budget.look_up_panorama || within_budget.fill_panorama || within_budget.store_panorama);
}

TEST(Plan, a_budget_that_is_short_draws_the_picture_smaller) {
    const FramePlan plan = plan_of({.budget_ms = 0.02, .fixed_near_m = 0.0, .use_panorama = false}, 60);
    EXPECT_EQ(plan.image_width, 64);
    EXPECT_EQ(plan.view.width, 16);  // a quarter: no budget makes it less
    EXPECT_EQ(plan.view.height, 12);
    EXPECT_FALSE(plan.look_up_panorama);
}

TEST(Plan, an_ample_budget_stays_sharp_while_the_panorama_is_filled) {
    for (const int frames_at_rest : {1, 2, 3, 10}) {
        const FramePlan plan = plan_of({.budget_ms = 1000.0, .fixed_near_m = 0.0}, frames_at_rest);
        EXPECT_EQ(plan.view.width, 64) << frames_at_rest;
        EXPECT_TRUE(plan.fill_panorama) << frames_at_rest;
    }
}

TEST(Plan, an_ample_budget_draws_the_picture_as_it_is) {
    const FramePlan plan = plan_of({.budget_ms = 1000.0, .fixed_near_m = 0.0, .use_panorama = false}, 60);
    EXPECT_EQ(plan.view.width, 64);
    EXPECT_EQ(plan.view.height, 48);
}

TEST(Plan, raycast_uses_nothing_but_embree) {
    EXPECT_EQ(to_text(plan_of({.mode = Mode::raycast}, 4)),
              "mode raycast\n"
              "near field none, 0 m\n"
              "horizon off, every 1 azimuths\n"
              "panorama not used, up to 0.5 px\n"
              "rays as many as needed by embree\n");
}

TEST(Plan, raster_draws_everything_through_opengl) {
    EXPECT_EQ(to_text(plan_of({.mode = Mode::raster}, 0)),
              "mode raster\n"
              "near field rasterised, inf m\n"
              "horizon off, every 1 azimuths\n"
              "panorama not used, up to 0.5 px\n"
              "rays as many as needed by beam\n");
}

TEST(Plan, a_fixed_near_distance_is_kept) {
    const FramePlan plan = plan_of({.fixed_near_m = 75.0}, 4);
    EXPECT_TRUE(plan.rasterise);
    EXPECT_EQ(plan.near_m, 75.0);
}

}  // namespace
}  // namespace ff::frame
