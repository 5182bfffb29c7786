#include "engine/debug/debug_view.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace ff::debug {
namespace {

TEST(DebugView, every_source_has_a_colour_and_a_name_of_its_own) {
    std::set<std::uint32_t> colors;
    std::set<std::string_view> names;
    for (std::size_t i = 0; i < kPixelSourceCount; ++i) {
        EXPECT_EQ(std::size_t(source_colors()[i].source), i);
        colors.insert(source_colors()[i].rgba);
        names.insert(source_colors()[i].name);
    }
    EXPECT_EQ(colors.size(), kPixelSourceCount);
    EXPECT_EQ(names.size(), kPixelSourceCount);
}

TEST(DebugView, pixels_are_painted_by_their_source_whatever_the_stride) {
    const int width = 5, height = 3, stride = 32;
    std::vector<PixelSource> sources(stride * height, PixelSource::sky);
    sources[2 * stride + 4] = PixelSource::near;
    sources[0] = PixelSource(200);
    shading::Image image;
    paint_sources(sources, width, height, stride, image);
    EXPECT_EQ(image.width, width);
    EXPECT_EQ(image.pixels[0], 0xFFFF00FFu);
    EXPECT_EQ(image.pixels[1], source_colors()[std::size_t(PixelSource::sky)].rgba);
    EXPECT_EQ(image.pixels[std::size_t(2 * image.stride + 4)], source_colors()[std::size_t(PixelSource::near)].rgba);
}

TEST(DebugView, a_shaded_picture_shows_through_the_sources) {
    std::vector<PixelSource> sources(16 * 16, PixelSource::panorama);
    shading::Image shaded, image;
    shaded.resize(2, 1);
    shaded.pixels[0] = 0xFF000000u;
    shaded.pixels[1] = 0xFFFFFFFFu;
    paint_sources(sources, 2, 1, 16, image, &shaded);
    EXPECT_LT(image.pixels[0] >> 8 & 255u, image.pixels[1] >> 8 & 255u);
    EXPECT_EQ(image.pixels[1], source_colors()[std::size_t(PixelSource::panorama)].rgba);
}

TEST(DebugView, causes_have_the_colours_of_the_paper_and_the_dearest_tile_is_red) {
    using farfield::PixelCause;
    shading::Image image;
    const std::vector<PixelCause> causes{PixelCause::verified, PixelCause::failed, PixelCause::resampled,
                                         PixelCause::abrupt};
    paint_causes(causes, 4, 1, 4, image);
    const auto channel = [&](int x, int shift) { return image.pixels[std::size_t(x)] >> shift & 255u; };
    EXPECT_GT(channel(0, 0), 2 * channel(0, 8)) << "red";
    EXPECT_GT(channel(1, 8), 2 * channel(1, 0)) << "green";
    EXPECT_EQ(image.pixels[2], 0xFFFFFFFFu);
    EXPECT_GT(channel(3, 16), 2 * channel(3, 0)) << "blue";

    const std::vector<std::uint64_t> work{0, 70, 7, 7};
    paint_tile_work(work, 20, 32, image);
    EXPECT_EQ(image.pixels[0], 0xFFFF0000u) << "nothing is blue";
    EXPECT_EQ(image.pixels[16], 0xFF0000FFu) << "the most is red";
    EXPECT_EQ(image.pixels[19], 0xFF0000FFu);
    EXPECT_EQ(image.pixels[0], image.pixels[std::size_t(15 * image.stride)]);
    EXPECT_NE(image.pixels[0], image.pixels[std::size_t(16 * image.stride)]);
}

TEST(DebugView, ages_run_from_blue_to_red_and_nothing_is_black) {
    const std::vector<std::uint16_t> ages{0, 30, 60, 1000, kNoAge};
    shading::Image image;
    paint_ages(ages, 5, 1, 5, 60, image);
    EXPECT_EQ(image.pixels[0], 0xFFFF0000u);
    EXPECT_EQ(image.pixels[2], 0xFF0000FFu);
    EXPECT_EQ(image.pixels[3], 0xFF0000FFu);
    EXPECT_EQ(image.pixels[4], 0xFF000000u);
    paint_ages(ages, 5, 1, 5, 0, image);  // a limit of 0 is the smallest there is
    EXPECT_EQ(image.pixels[1], 0xFF0000FFu);
}

TEST(DebugView, the_near_border_is_a_line_on_the_near_side) {
    shading::Image image;
    image.resize(4, 4);
    std::vector<PixelSource> sources(image.pixels.size(), PixelSource::cast_hit);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 3; ++x) sources[std::size_t(y * image.stride + x)] = PixelSource::near;
    draw_near_border(sources, image);
    for (int y = 0; y < 4; ++y) {
        EXPECT_EQ(image.pixels[std::size_t(y * image.stride + 1)], 0u);
        EXPECT_EQ(image.pixels[std::size_t(y * image.stride + 2)], 0xFFFFFFFFu);
        EXPECT_EQ(image.pixels[std::size_t(y * image.stride + 3)], 0u);
    }
}

}  // namespace
}  // namespace ff::debug
