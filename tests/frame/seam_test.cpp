// The border of near and far field cannot be seen: wherever it runs, the picture is the same.

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/frame/renderer.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/shading/image_difference.h"
#include "tests/gl/gl_fixture.h"
#include "tests/support/town.h"
#include "tests/support/wind.h"
#include "tests/support/worlds.h"

namespace ff::frame {
namespace {

constexpr int kWidth = 320, kHeight = 240;

// Tolerance. Rasteriser and caster round edges and texel borders the other way here and there: single pixels.
constexpr double kLeastPsnrDb = 44.0;
constexpr int kLevels = 3;             ///< of 255; what the two shading programs may differ by
constexpr double kMostWrong = 0.0005;  ///< share of pixels off by more than kLevels

class SeamTest : public test::GlTest {
  protected:
    /// Draws the town from some places with each near distance, and compares each with a picture without a near field.
    void expect_no_seam(const scene::SceneData& town) {
        const scene::StaticScene scene = town.view();
        auto near_renderer = nearfield::NearRenderer::make(scene);
        ASSERT_TRUE(near_renderer) << near_renderer.error().message;
        Casters casters(scene);
        const Camera cameras[] = {{.position = {0.5, 1.7, 60.0}, .yaw = 0.05},
                                  {.position = {-3.0, 1.7, -40.0}, .yaw = 0.7, .pitch = 0.08},
                                  {.position = {60.0, 30.0, 150.0}, .yaw = -0.4, .pitch = -0.2, .roll = 0.1},
                                  {.position = {0.0, 4.0, -90.0}, .yaw = 3.0, .vertical_fov = 0.5}};
        for (const Camera& camera : cameras) {
            shading::Image far_only;
            draw(scene, casters, *near_renderer, camera, 0.0, far_only);
            std::uint64_t covered = 0;
            for (const double near_m : {50.0, 100.0, 400.0}) {
                shading::Image image;
                const std::uint64_t near_pixels = draw(scene, casters, *near_renderer, camera, near_m, image);
                // The border does move: else the comparison would say nothing.
                EXPECT_GT(near_pixels, covered) << near_m << " m";
                covered = near_pixels;
                const shading::ImageDifference difference = shading::compare_images(image, far_only, kLevels);
                fmt::print(stderr, "near {:3} m, {:5} pixels of it: {:.1f} dB, {:.5f} wrong\n", near_m, near_pixels,
                           difference.psnr_db, difference.wrong_pixels);
                EXPECT_GE(difference.psnr_db, kLeastPsnrDb) << near_m << " m, yaw " << camera.yaw;
                EXPECT_LE(difference.wrong_pixels, kMostWrong) << near_m << " m, yaw " << camera.yaw;
            }
        }
    }

    /// @return pixels that the rasteriser answered
    static std::uint64_t draw(const scene::StaticScene& scene, Casters& casters, nearfield::NearRenderer& near_renderer,
                              const Camera& camera, double near_m, shading::Image& image) {
        Renderer renderer(scene, casters, &near_renderer, kWidth, kHeight);
        return renderer.draw(camera, {}, {.fixed_near_m = near_m, .time_s = 2.6}, image).pixels.near_field;
    }
};

TEST_F(SeamTest, a_near_distance_of_50_100_or_400_m_draws_the_same_town) {
    expect_no_seam(test::make_small_town());
}

TEST_F(SeamTest, leaves_in_the_wind_have_no_seam_either) {
    scene::SceneData town = test::make_small_town();
    test::let_leaves_sway(town);
    town.environment.weather.wind_m_s = {8.0f, 3.0f};
    expect_no_seam(town);
}

TEST_F(SeamTest, panes_of_glass_have_no_seam_either) {
    expect_no_seam(test::make_small_town({.glass = true}));
}

/// A field that starts at the viewer and ends in a wall 300 m away is one cell; a house before that wall is another.
scene::SceneData make_house_before_a_near_cell_s_wall() {
    scene::SceneData scene;
    scene.materials.push_back(test::plain_material());
    const auto add = [&](const Vec3& low, const Vec3& high, std::uint32_t cell) {
        scene::MeshSource mesh;
        test::append_box(mesh, low, high, 4, 0);
        const std::uint32_t id = scene.add_mesh(scene::prepare_mesh(std::move(mesh), scene.materials));
        scene.add_instance(id, WorldPos(0.0), Mat3(1.0f), cell);
    };
    add({-200.0f, -1.0f, -300.0f}, {200.0f, 0.0f, 10.0f}, 0);
    add({-200.0f, 0.0f, -302.0f}, {200.0f, 80.0f, -300.0f}, 0);
    add({-20.0f, 0.0f, -180.0f}, {20.0f, 30.0f, -150.0f}, 1);
    scene.finish(64);
    return scene;
}

TEST_F(SeamTest, a_near_cell_s_far_end_hides_nothing_that_stands_before_it_in_a_cell_not_drawn) {
    const scene::SceneData data = make_house_before_a_near_cell_s_wall();
    const scene::StaticScene scene = data.view();
    auto near_renderer = nearfield::NearRenderer::make(scene);
    ASSERT_TRUE(near_renderer) << near_renderer.error().message;
    Casters casters(scene);
    const Camera camera{.position = {0.0, 1.7, 0.0}};
    shading::Image far_only, image;
    draw(scene, casters, *near_renderer, camera, 0.0, far_only);
    EXPECT_GT(draw(scene, casters, *near_renderer, camera, 50.0, image), 100u);
    EXPECT_LE(shading::compare_images(image, far_only, kLevels).wrong_pixels, kMostWrong);
}

}  // namespace
}  // namespace ff::frame
