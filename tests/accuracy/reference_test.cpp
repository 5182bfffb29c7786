#include "tools/accuracy/reference.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/accuracy/images.h"
#include "tests/support/temporary_folder.h"

namespace ff::accuracy {
namespace {

TEST(AverageTest, averages_light_not_levels) {
    shading::Image samples = test::plain_image(8, 4, 0xFF000000u);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 2; ++x) samples.pixels[std::size_t(y * samples.stride + x)] = 0xFFFFFFFFu;
    shading::Image out;
    average_samples(samples, out);
    ASSERT_EQ(out.width, 2);
    ASSERT_EQ(out.height, 1);
    EXPECT_EQ(out.pixels[0], 0xFFBCBCBCu);  // half of the light is level 188
    EXPECT_EQ(out.pixels[1], 0xFF000000u);
}

TEST(ReferenceTest, is_kept_and_read_back_and_a_damaged_one_is_made_anew) {
    const scene::World world(test::make_city({.cells = 2}), {.name = "city"});
    frame::Casters casters(world.scene());
    scene::Walk walk;
    walk.frames.push_back({.position = {20.0, 40.0, 20.0}, .yaw_deg = 40.0, .pitch_deg = -10.0});
    const LabScene lab{.world = world,
                       .walk = walk,
                       .moving = {},
                       .width = 64,
                       .height = 48,
                       .make_renderer = [&](int width, int height) {
                           return std::make_unique<frame::Renderer>(world.scene(), casters, nullptr, width, height);
                       }};
    const test::TemporaryFolder temporary;
    const std::filesystem::path folder = temporary / "references";
    const auto frames = schedule(1, kQuick);
    const auto made = make_reference(lab, frames, folder);
    ASSERT_TRUE(made) << made.error().message;
    std::vector<std::filesystem::path> kept;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) kept.push_back(entry.path());
    ASSERT_EQ(kept.size(), 1u);
    const auto read = make_reference(lab, frames, folder);
    ASSERT_TRUE(read);
    EXPECT_EQ(made->front().image.pixels, read->front().image.pixels);
    std::ofstream(kept.front(), std::ios::trunc) << "no picture";
    const auto again = make_reference(lab, frames, folder);
    ASSERT_TRUE(again);
    EXPECT_EQ(made->front().image.pixels, again->front().image.pixels);
}

}  // namespace
}  // namespace ff::accuracy
