#include "engine/host/player_settings.h"

#include <gtest/gtest.h>

namespace ff::host {
namespace {

std::vector<loop::Action> actions() {
    return {{"ahead", {*loop::parse_trigger("w")}},
            {"back", {*loop::parse_trigger("s")}},
            {"left", {*loop::parse_trigger("a")}},
            {"right", {*loop::parse_trigger("d")}},
            {"use", {*loop::parse_trigger("e"), *loop::parse_trigger("pad x")}}};
}

TEST(PlayerSettings, are_read_as_they_are_written) {
    PlayerSettings settings = default_settings(actions());
    settings.fov_deg = 80;
    settings.budget_ms = 16.5;
    settings.error_px = 1.5;
    settings.width = 800;
    settings.height = 600;
    settings.invert_pitch = true;
    settings.volume = 0.25;
    settings.actions[4].triggers[0] = *loop::parse_trigger("mouse right");
    const auto read = read_settings(to_text(settings), "settings.toml", actions());
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(to_text(*read), to_text(settings));
    EXPECT_EQ(read->actions[4].triggers[0], *loop::parse_trigger("mouse right"));
}

TEST(PlayerSettings, a_negative_zero_is_read_as_it_is_written) {
    const auto first = read_settings("fov_deg = -0.0\n", "settings.toml", actions());
    ASSERT_TRUE(first) << first.error().message;
    const auto again = read_settings(to_text(*first), "settings.toml", actions());
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(to_text(*again), to_text(*first));
}

TEST(PlayerSettings, keys_that_are_not_there_keep_the_games_values) {
    const auto read = read_settings("mouse_speed = 2.0\n", "settings.toml", actions());
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->mouse_speed, 2.0);
    EXPECT_EQ(read->budget_ms, default_settings(actions()).budget_ms);
    EXPECT_EQ(read->actions[0].triggers[0], *loop::parse_trigger("w"));
}

TEST(PlayerSettings, what_is_wrong_is_said_with_its_line) {
    const auto message = [](const char* text) {
        const auto read = read_settings(text, "s.toml", actions());
        return read ? std::string() : read.error().message;
    };
    EXPECT_NE(message("width = 640\nheight = 5\n").find("s.toml:2: height"), std::string::npos);
    EXPECT_NE(message("fov_deg = nan\n").find("fov_deg"), std::string::npos);
    EXPECT_NE(message("colour = 3\n").find("no setting 'colour'"), std::string::npos);
    EXPECT_NE(message("[keys]\nfly = [\"w\"]\n").find("no action 'fly'"), std::string::npos);
    EXPECT_NE(message("[keys]\nuse = [\"ee\"]\n").find("nearest"), std::string::npos);
    EXPECT_NE(message("= 3").find("not TOML"), std::string::npos);
}

}  // namespace
}  // namespace ff::host
