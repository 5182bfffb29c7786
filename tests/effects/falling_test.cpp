// Rain and snow in the air.

#include "engine/effects/falling.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/worlds.h"

namespace ff::effects {
namespace {

constexpr int kWidth = 160, kHeight = 120;

/// A picture of rain over nothing.
struct Picture {
    PinholeView view;
    farfield::VisibilityBuffer visible;
    shading::Image image;
    Shelter shelter;
    std::unique_ptr<farfield::RayCaster> caster;

    explicit Picture(const scene::StaticScene& scene, const Camera& camera = {.position = {0.0, 2.0, 0.0}})
        : view(make_view(camera, kWidth, kHeight)), caster(farfield::make_embree_caster(scene)) {
        visible.resize(kWidth, kHeight);
        std::fill(visible.depth.begin(), visible.depth.end(), std::numeric_limits<float>::infinity());
        image.resize(kWidth, kHeight);
        std::fill(image.pixels.begin(), image.pixels.end(), 0xFF000000u);
        while (shelter.update(camera.position, *caster) > 0) continue;
    }
    std::size_t lit_pixels() const {
        return std::size_t(std::count_if(image.pixels.begin(), image.pixels.end(),
                                         [](std::uint32_t pixel) { return (pixel & 0xFFFFFFu) != 0; }));
    }
};

TEST(Fall, rain_and_snow_show_and_move_with_time_alone) {
    const scene::SceneData data = test::make_empty_world();
    for (const scene::Weather& weather : {scene::Weather{.rain = 1.0f}, scene::Weather{.snow = 1.0f}}) {
        std::vector<ZeroPageVector<std::uint32_t>> images;
        for (const double time_s : {0.0, 0.1, 0.0, 3611.3}) {
            Picture picture(data.view());
            EXPECT_GT(draw_fall({.weather = weather, .time_s = time_s}, picture.view, picture.visible, picture.shelter,
                                picture.image),
                      100u);
            EXPECT_GT(picture.lit_pixels(), 100u);
            images.push_back(picture.image.pixels);
        }
        EXPECT_EQ(images[0], images[2]);
        EXPECT_NE(images[0], images[1]);
        EXPECT_NE(images[0], images[3]);
    }
}

TEST(Fall, more_falls_where_more_is_asked_for) {
    const scene::SceneData data = test::make_empty_world();
    std::uint64_t last = 0;
    for (const float rain : {0.0f, 0.1f, 0.5f, 1.0f}) {
        Picture picture(data.view());
        const std::uint64_t shown =
            draw_fall({.weather = {.rain = rain}}, picture.view, picture.visible, picture.shelter, picture.image);
        if (rain == 0.0f) {
            EXPECT_EQ(shown, 0u);
        } else {
            EXPECT_GT(shown, last);
        }
        last = shown;
    }
}

TEST(Fall, nothing_shows_behind_walls) {
    const scene::SceneData data = test::make_empty_world();
    Picture picture(data.view());
    std::fill(picture.visible.depth.begin(), picture.visible.depth.end(), 0.3f);
    EXPECT_EQ(draw_fall({.weather = {.rain = 1.0f, .snow = 1.0f}}, picture.view, picture.visible, picture.shelter,
                        picture.image),
              0u);
    EXPECT_EQ(picture.lit_pixels(), 0u);
}

TEST(Fall, it_stays_dry_under_a_roof) {
    const scene::SceneData data = test::make_single_triangle({-90, 8, 90}, {90, 8, 90}, {0, 8, -180});
    Picture under(data.view());
    EXPECT_EQ(under.shelter.top_at(0.3, 0.3), 8.0f);
    EXPECT_EQ(draw_fall({.weather = {.rain = 1.0f}}, under.view, under.visible, under.shelter, under.image), 0u);
    Picture above(data.view(), {.position = {0.0, 12.0, 0.0}});
    EXPECT_GT(draw_fall({.weather = {.rain = 1.0f}}, above.view, above.visible, above.shelter, above.image), 50u);
}

TEST(Shelter, casts_only_for_squares_that_are_new) {
    const scene::SceneData data = test::make_single_triangle({-90, 8, 90}, {90, 8, 90}, {0, 8, -180});
    const auto caster = farfield::make_embree_caster(data.view());
    Shelter shelter;
    std::uint64_t all = 0;
    for (int f = 0; f < 8; ++f) {
        const std::uint64_t rays = shelter.update({0.5, 2.0, 0.5}, *caster);
        EXPECT_LE(rays, Shelter::kRaysAFrame);
        all += rays;
    }
    EXPECT_GT(all, 250u);
    EXPECT_LE(all, std::uint64_t(Shelter::kSide * Shelter::kSide));
    EXPECT_EQ(shelter.update({0.9, 2.0, 0.1}, *caster), 0u) << "the same square";
    EXPECT_LE(shelter.update({1.5, 2.0, 0.5}, *caster), std::uint64_t(Shelter::kSide)) << "a step to the side";
    shelter.clear();
    EXPECT_GT(shelter.update({1.5, 2.0, 0.5}, *caster), 0u);
}

}  // namespace
}  // namespace ff::effects
