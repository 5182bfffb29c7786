#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/core/jobs.h"
#include "engine/farfield/visibility_difference.h"
#include "engine/frame/renderer.h"
#include "engine/shading/image_difference.h"
#include "tests/support/wind.h"
#include "tests/support/worlds.h"

namespace ff::frame {
namespace {

constexpr int kWidth = 200, kHeight = 150;  // neither is a multiple of a tile

double psnr_db(const shading::Image& a, const shading::Image& b) {
    return shading::compare_images(a, b, 0).psnr_db;
}

class FrameTest : public testing::Test {
  protected:
    FrameTest() : data(test::make_city({.cells = 4})), scene(data.view()), casters(scene) {}

    scene::SceneData data;
    scene::StaticScene scene;
    Casters casters;
};

Camera street_camera(double yaw) {
    return {.position = {0.0, 1.7, 0.0}, .yaw = yaw};
}

TEST_F(FrameTest, sources_of_pixels_add_up_to_the_image) {
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    for (int f = 0; f < 12; ++f) {
        const FrameStats& stats = renderer.draw(street_camera(0.05 * std::min(f, 6)), {}, {.fixed_near_m = 0.0}, image);
        EXPECT_EQ(stats.pixels.near_field + stats.pixels.sky + stats.pixels.panorama + stats.pixels.cast_hit +
                      stats.pixels.cast_miss,
                  std::uint64_t(kWidth * kHeight))
            << "frame " << f;
    }
}

TEST_F(FrameTest, a_walking_hybrid_draws_what_raycast_draws) {
    Renderer hybrid(scene, casters, nullptr, kWidth, kHeight);
    Renderer raycast(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    for (int f = 0; f < 20; ++f) {
        Camera camera = street_camera(0.3 + 0.01 * f);
        camera.position.z -= 0.05 * f;
        hybrid.draw(camera, {}, {.fixed_near_m = 0.0}, image);
        raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
        EXPECT_GE(psnr_db(image, reference), 32.0) << "frame " << f;
    }
}

TEST_F(FrameTest, who_stands_and_takes_a_spyglass_sees_as_sharply_as_by_raycast) {
    Renderer hybrid(scene, casters, nullptr, kWidth, kHeight);
    Renderer raycast(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    Camera camera = street_camera(0.3);
    for (int f = 0; f < 24; ++f) {
        camera.vertical_fov = radians_of(f < 8 || f >= 16 ? 60.0 : 5.0);
        const FrameStats& stats = hybrid.draw(camera, {}, {.fixed_near_m = 0.0}, image);
        raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
        const bool through_spyglass = f >= 8 && f < 16;
        EXPECT_GE(psnr_db(image, reference), through_spyglass ? 50.0 : 30.0) << "frame " << f;
        if (f == 7 || f == 23) {
            EXPECT_GT(stats.pixels.panorama, 0u) << "frame " << f;
        }
    }
}

TEST_F(FrameTest, beams_and_known_primitives_draw_what_raycast_draws) {
    for (const Mode mode : {Mode::beam, Mode::irsa}) {
        Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
        Renderer raycast(scene, casters, nullptr, kWidth, kHeight);
        shading::Image image, reference;
        for (int f = 0; f < 6; ++f) {
            Camera camera = street_camera(0.3 + 0.1 * f);
            camera.position.z -= 0.5 * f;
            const FrameStats& stats = renderer.draw(camera, {}, {.mode = mode}, image);
            EXPECT_GT(mode == Mode::irsa ? stats.pixels.verified : stats.pixels.cast_hit, 0u);
            EXPECT_EQ(stats.pixels.sky + stats.pixels.verified + stats.pixels.cast_hit + stats.pixels.cast_miss,
                      std::uint64_t(kWidth * kHeight));
            raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
            EXPECT_LE(farfield::count_wrong_pixels(renderer.history().visibility, raycast.history().visibility), 3u)
                << "mode " << int(mode) << ", frame " << f;
        }
    }
}

TEST_F(FrameTest, a_reprojecting_walker_verifies_most_pixels_and_draws_what_raycast_draws) {
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    Renderer raycast(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    for (int f = 0; f < 20; ++f) {
        Camera camera = street_camera(0.3 + 0.005 * f);
        camera.position += world_from_camera(camera) * DVec3(0.0, 0.0, -0.03 * f);
        const FrameStats& stats = renderer.draw(camera, {}, {.mode = Mode::reproject}, image);
        const PixelCounts& pixels = stats.pixels;
        EXPECT_EQ(pixels.sky + pixels.verified + pixels.cast_hit + pixels.cast_miss, std::uint64_t(kWidth * kHeight));
        if (f > 0) {
            EXPECT_GE(pixels.sky + pixels.verified, std::uint64_t(0.8 * kWidth * kHeight)) << "frame " << f;
        }
        raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
        EXPECT_LE(farfield::count_wrong_pixels(renderer.history().visibility, raycast.history().visibility),
                  std::uint64_t(0.005 * kWidth * kHeight))
            << "frame " << f;
    }
    // Another mode in between leaves nothing to reproject, or something that is right.
    renderer.draw(street_camera(1.0), {}, {}, image);
    EXPECT_EQ(renderer.draw(street_camera(1.0), {}, {.mode = Mode::reproject}, image).pixels.verified, 0u);
}

TEST_F(FrameTest, reprojection_goes_on_at_any_resolution_and_starts_anew_where_that_changes) {
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    int f = 0;
    for (const float resolution : {1.0f, 0.5f, 0.7f}) {
        const FrameSettings settings{.mode = Mode::reproject, .resolution = resolution};
        EXPECT_EQ(renderer.draw(street_camera(0.005 * f++), {}, settings, image).pixels.verified, 0u) << resolution;
        const FrameStats& stats = renderer.draw(street_camera(0.005 * f++), {}, settings, image);
        EXPECT_GE(double(stats.pixels.sky + stats.pixels.verified),
                  0.5 * double(resolution * kWidth) * double(resolution * kHeight))
            << resolution;
    }
}

TEST_F(FrameTest, a_changed_region_is_cast_again_in_the_next_frame_and_only_then) {
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    const FrameSettings settings{.mode = Mode::reproject};
    const auto answered = [&] {
        const PixelCounts& pixels = renderer.draw(street_camera(0.3), {}, settings, image).pixels;
        return pixels.sky + pixels.verified;
    };
    renderer.region_changed(scene.bounds);  // nothing is known yet
    answered();
    const std::uint64_t usual = answered();
    EXPECT_GE(usual, std::uint64_t(0.8 * kWidth * kHeight));
    renderer.region_changed(scene.bounds);
    EXPECT_LT(answered(), usual / 2) << "sky past the scene's box alone";
    EXPECT_GE(answered(), usual - usual / 20);
}

TEST_F(FrameTest, images_of_any_size_are_drawn_alike_in_every_mode) {
    const scene::StaticScene nothing;
    Casters no_casters(nothing);
    const int sizes[][2] = {{1, 1}, {1, 40}, {15, 1}, {16, 16}, {17, 33}, {31, 15}};
    for (const auto& [width, height] : sizes)
        for (const Mode mode : {Mode::hybrid, Mode::raycast, Mode::beam, Mode::reproject, Mode::irsa}) {
            Renderer renderer(scene, casters, nullptr, width, height), raycast(scene, casters, nullptr, width, height);
            Renderer empty(nothing, no_casters, nullptr, width, height);
            shading::Image image, reference;
            for (int f = 0; f < 4; ++f) {
                const auto count = [](const PixelCounts& p) {
                    return p.near_field + p.sky + p.panorama + p.verified + p.cast_hit + p.cast_miss;
                };
                const auto pixels = std::uint64_t(width) * std::uint64_t(height);
                const FrameSettings settings{.mode = mode, .fixed_near_m = 0.0, .keep_ids = true};
                const Camera camera = street_camera(0.3 + 0.001 * f);
                EXPECT_EQ(count(renderer.draw(camera, {}, settings, image).pixels), pixels);
                raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
                // Edges are most of so small an image, and there a panorama's texel may be the neighbour's.
                EXPECT_LE(farfield::count_wrong_pixels(renderer.history().visibility, raycast.history().visibility),
                          mode == Mode::hybrid ? pixels / 10 + 1 : pixels / 50)
                    << "mode " << int(mode) << ", " << width << "x" << height << ", frame " << f;
                const PixelCounts& none = empty.draw(camera, {}, settings, image).pixels;
                EXPECT_EQ(count(none), pixels);
                EXPECT_EQ(none.cast_hit, 0u);
            }
        }
}

TEST_F(FrameTest, a_turning_hybrid_reuses_most_pixels_and_stays_close_to_raycast) {
    Renderer hybrid(scene, casters, nullptr, kWidth, kHeight);
    Renderer raycast(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    for (int f = 0; f < 20; ++f) {
        const Camera camera = street_camera(0.3 + 0.02 * f);
        const FrameStats& stats = hybrid.draw(camera, {}, {.fixed_near_m = 0.0}, image);
        if (f >= 5) {
            EXPECT_GE(stats.pixels.panorama + stats.pixels.sky, stats.pixels.cast_hit) << "frame " << f;
        }
        raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
        EXPECT_GE(psnr_db(image, reference), 32.0) << "frame " << f;
    }
}

TEST(WindFrames, a_resting_viewer_sees_leaves_move_and_the_rest_come_from_the_panorama) {
    scene::SceneData data = test::make_forest({.trees = 40, .size_m = 300.0, .leaves = 200});
    test::let_leaves_sway(data);
    data.environment.weather.wind_m_s = {6.0f, 2.0f};
    const scene::StaticScene scene = data.view();
    Casters casters(scene);
    const auto tree = std::find_if(scene.instances.begin(), scene.instances.end(), [&](const scene::Instance& i) {
        return (scene.meshes[i.mesh].material_flags & scene::kMaterialSways) != 0;
    });
    ASSERT_NE(tree, scene.instances.end());
    const Camera camera{.position = tree->position + DVec3(3.0, 4.0, 5.0)};
    const auto settings_at = [](double time_s) { return FrameSettings{.fixed_near_m = 0.0, .time_s = time_s}; };
    Renderer resting(scene, casters, nullptr, kWidth, kHeight), fresh(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, before, exact;
    int changed = 0;
    for (int f = 0; f < 12; ++f) {
        FrameSettings settings = settings_at(0.3 * f);
        const FrameStats& stats = resting.draw(camera, {}, settings, image);
        EXPECT_EQ(stats.effects[effects::EffectId::wind].state, effects::State::active);
        EXPECT_EQ(stats.work(effects::EffectId::wind).rays, 0u);
        settings.mode = Mode::raycast;
        fresh.draw(camera, {}, settings, exact);
        if (f > 4) {
            EXPECT_GT(stats.pixels.panorama, std::uint64_t(kWidth * kHeight / 10)) << "far leaves stand still";
            EXPECT_GT(stats.pixels.cast_hit, 500u) << "near ones are cast";
            changed += shading::compare_images(image, before, 8).wrong_pixels > 0.002;
        }
        EXPECT_GT(psnr_db(image, exact), 30.0) << "frame " << f;
        before = image;
    }
    EXPECT_GE(changed, 6);
}

TEST_F(FrameTest, deterministic_frames_are_the_same_for_one_and_two_workers) {
    std::vector<ZeroPageVector<std::uint32_t>> images;
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
        shading::Image image;
        for (int f = 0; f < 10; ++f)
            renderer.draw(street_camera(0.02 * f), {}, {.fixed_near_m = 0.0, .deterministic = true}, image);
        images.push_back(image.pixels);
    }
    EXPECT_EQ(images[0], images[1]);
}

TEST_F(FrameTest, a_moving_instance_shows_before_what_is_farther_and_hides_behind_what_is_nearer) {
    scene::SceneData street = test::make_single_triangle({-2, 0, 0}, {2, 0, 0}, {0, 4, 0});  // 4 m wide, at z = 0
    const scene::StaticScene still = street.view();
    Casters own_casters(still);
    Renderer renderer(still, own_casters, nullptr, kWidth, kHeight);
    shading::Image image;
    const auto shown_at = [&](double z, int frames_at_rest) {
        scene::Instance moving = still.instances[0];
        moving.position.z = z;
        std::uint64_t shown = 0;
        for (int f = 0; f <= frames_at_rest; ++f)
            shown = renderer.draw({.position = {0, 1.7, 10}}, std::span(&moving, 1), {}, image).pixels.dynamic;
        return shown;
    };
    for (const int frames_at_rest : {0, 6}) {  // cast, and from the panorama
        EXPECT_GT(shown_at(5.0, frames_at_rest), 500u) << "before the triangle";
        EXPECT_EQ(shown_at(-0.5, frames_at_rest), 0u) << "behind the triangle, smaller by perspective";
    }
}

TEST_F(FrameTest, no_budget_however_small_leaves_a_pixel_without_colour) {
    for (const auto when_late : {budget::WhenLate::coarser, budget::WhenLate::stale}) {
        Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
        shading::Image image;
        for (int f = 0; f < 30; ++f) {
            Camera camera = street_camera(0.0);
            camera.position.x += 0.2 * f;
            renderer.draw(camera, {}, {.budget_ms = 0.05, .when_late = when_late, .fixed_near_m = 0.0}, image);
        }
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
                ASSERT_NE(image.pixels[std::size_t(y) * std::size_t(image.stride) + std::size_t(x)] & 0xFFFFFFu, 0u)
                    << x << ", " << y;
    }
}

TEST_F(FrameTest, a_short_budget_draws_a_blurred_picture_that_sharpens_when_the_viewer_stands) {
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    Renderer raycast(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    Camera camera = street_camera(0.0);
    const auto draw = [&] {  // recorded costs: the same on every machine
        return renderer.draw(camera, {}, {.budget_ms = 0.3, .fixed_near_m = 0.0, .deterministic = true}, image);
    };
    for (int f = 0; f < 40; ++f) {
        camera.position.x += 0.1;
        const FrameStats& stats = draw();
        ASSERT_EQ(image.width, kWidth);
        if (f > 20) {
            EXPECT_LT(stats.resolution, 1.0) << "frame " << f;
        }
    }
    raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
    const double moving_db = psnr_db(image, reference);
    EXPECT_GE(moving_db, 20.0);
    for (int f = 0; f < 60; ++f) draw();
    EXPECT_EQ(renderer.history().last_stats.resolution, 1.0);
    EXPECT_GE(psnr_db(image, reference), std::max(32.0, moving_db));
}

}  // namespace
}  // namespace ff::frame
