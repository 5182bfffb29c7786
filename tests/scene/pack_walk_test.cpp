#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "engine/scene/walk.h"

namespace ff::scene {
namespace {

std::string with_frame(const std::string& frame) {
    return "{\"format\": 1, \"fov_deg\": 60, \"rate_hz\": 30,\n \"frames\": [\n" + frame + "]}";
}

/// The message of a walk that must not be read.
std::string problem_of(const std::string& text) {
    const auto walk = parse_walk(text, "w.walk.json", "w");
    if (walk) return "was read";
    EXPECT_EQ(walk.error().kind, ErrorKind::bad_input);
    return walk.error().message;
}

TEST(Walk, reads_the_documented_example) {
    const auto walk =
        parse_walk(with_frame("{\"p\": [1, 2.5, -3e2], \"yaw_deg\": 90, \"pitch_deg\": -10}"), "f", "main");
    ASSERT_TRUE(walk) << walk.error().message;
    EXPECT_EQ(walk->name, "main");
    ASSERT_EQ(walk->frames.size(), 1u);
    EXPECT_EQ(walk->frames[0].position, WorldPos(1, 2.5, -300));
    EXPECT_EQ(walk->frames[0].roll_deg, 0.0);
    const Camera camera = walk->camera(0);
    EXPECT_DOUBLE_EQ(camera.yaw, kPi / 2);
    EXPECT_DOUBLE_EQ(camera.pitch, radians_of(-10));
    EXPECT_DOUBLE_EQ(camera.vertical_fov, radians_of(60));
}

TEST(Walk, is_read_back_equal_to_what_was_written) {
    Walk walk{.name = "w", .fov_deg = 59.99999999, .rate_hz = 1.0 / 3.0, .frames = {}};
    for (int i = 0; i < 100; ++i)
        walk.frames.push_back({WorldPos(1e6 / (i + 3.0), -i / 7.0, 1e-300 * i), i * 3.7, -i * 0.9, i / 11.0});
    const auto back = parse_walk(walk_to_json(walk), "f", "w");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(*back, walk);
}

TEST(Walk, with_an_unknown_key_names_it_its_line_and_the_nearest) {
    EXPECT_EQ(problem_of(with_frame("{\"p\": [0, 0, 0],\n \"yaw\": 3}")),
              "w.walk.json:4: frames[0]: unknown key \"yaw\"; the nearest known one is \"yaw_deg\"");
    EXPECT_EQ(problem_of("{\n\"rate\": 3}"),
              "w.walk.json:2: the walk: unknown key \"rate\"; the nearest known one is \"rate_hz\"");
}

TEST(Walk, without_a_needed_key_names_it) {
    EXPECT_EQ(problem_of("{\"format\": 1, \"fov_deg\": 60, \"frames\": []}"),
              "w.walk.json:1: the walk has no \"rate_hz\"; expected one");
    EXPECT_EQ(problem_of(with_frame("{\"yaw_deg\": 3}")), "w.walk.json:3: frames[0] has no \"p\"; expected one");
}

TEST(Walk, of_the_wrong_shape_says_where_and_what_was_expected) {
    EXPECT_EQ(problem_of("[1]"),
              "w.walk.json:1: the file: an array; expected an object {\"format\": 1, \"fov_deg\", "
              "\"rate_hz\", \"frames\"}");
    EXPECT_EQ(problem_of(with_frame("{\"p\": [0, 0, 0], \"yaw_deg\": \"north\"}")),
              "w.walk.json:3: frames[0].yaw_deg: \"north\"; expected a number of degrees");
    EXPECT_EQ(problem_of(with_frame("{\"p\": [0, 0]}")),
              "w.walk.json:3: frames[0].p[2]: the end after 2 numbers; expected three numbers, metres");
    EXPECT_EQ(problem_of(with_frame("{\"p\": [0, 0, 0, 0]}")),
              "w.walk.json:3: frames[0].p[3]: the number 0; expected three numbers, metres");
    EXPECT_EQ(problem_of(with_frame("{\"p\": [0, 0, null]}")),
              "w.walk.json:3: frames[0].p[2]: null; expected three numbers, metres");
    EXPECT_EQ(problem_of("{\"format\": 2}"),
              "w.walk.json:1: format: 2; expected 1, the format that this program reads");
    EXPECT_EQ(problem_of("{\"format\": 1, \"format\": 1}"),
              "w.walk.json:1: the walk: key \"format\" stands twice; expected once");
}

TEST(Walk, that_is_no_json_names_the_line) {
    EXPECT_TRUE(problem_of("").starts_with("w.walk.json:1: no JSON: "));
    EXPECT_TRUE(problem_of("{\"format\": 1,\n\n oops}").starts_with("w.walk.json:3: no JSON: "));
    EXPECT_TRUE(problem_of(with_frame("{\"p\": [NaN, 0, 0]}")).starts_with("w.walk.json:3: no JSON: "));
    EXPECT_TRUE(problem_of(with_frame("{\"p\": [1e999, 0, 0]}")).starts_with("w.walk.json:3: no JSON: "));
    EXPECT_TRUE(problem_of(std::string(100000, '[')).starts_with("w.walk.json:1: the file: an array"));
    const std::string good = with_frame("{\"p\": [0, 0, 0]}");
    for (std::size_t size = 0; size < good.size(); ++size)
        EXPECT_NE(problem_of(good.substr(0, size)), "was read") << size;
    EXPECT_NE(problem_of(good + "x"), "was read");
}

TEST(Walk, with_numbers_out_of_range_says_which) {
    const auto lens = [](const char* fov, const char* rate) {
        return std::string("{\"format\": 1, \"fov_deg\": ") + fov + ", \"rate_hz\": " + rate +
               ", \"frames\": [{\"p\": [0, 0, 0]}]}";
    };
    EXPECT_EQ(problem_of(lens("200", "30")), "w.walk.json: fov_deg: 200; expected degrees in [1, 170]");
    EXPECT_EQ(problem_of(lens("60", "0")), "w.walk.json: rate_hz: 0; expected frames per second in (0, 10000]");
    EXPECT_EQ(problem_of(with_frame("")), "w.walk.json: frames: 0 of them; expected 1 to 1000000");
    EXPECT_EQ(problem_of(with_frame("{\"p\": [0, 1e10, 0]}")),
              "w.walk.json: frames[0].p[1]: 10000000000; expected metres within 1e+09 of the origin");
    EXPECT_EQ(problem_of(with_frame("{\"p\": [0, 0, 0], \"pitch_deg\": 91}")),
              "w.walk.json: frames[0].pitch_deg: 91; expected degrees in [-90, 90]");
}

TEST(Walk, with_numbers_that_are_none_is_a_problem_also_where_no_text_was_read) {
    Walk walk{.name = "w", .frames = {WalkFrame{}}};
    EXPECT_EQ(find_walk_problem(walk), "");
    walk.frames[0].yaw_deg = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(find_walk_problem(walk), "");
    walk.frames[0] = WalkFrame{};
    walk.fov_deg = std::numeric_limits<double>::infinity();
    EXPECT_NE(find_walk_problem(walk), "");
}

TEST(Walk, with_too_many_frames_is_refused) {
    std::string frames;
    for (std::size_t i = 0; i <= kMaxWalkFrames; ++i) frames += i == 0 ? "{\"p\":[0,0,0]}" : ",{\"p\":[0,0,0]}";
    EXPECT_EQ(problem_of(with_frame(frames)), "w.walk.json:3: frames: more than 1000000; expected at most as many");
}

}  // namespace
}  // namespace ff::scene
