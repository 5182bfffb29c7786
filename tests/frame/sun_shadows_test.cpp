// Sun shadows through whole frames: where they fall, that reused light is that of a ray each, and that who wants none
// pays for none.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/frame/renderer.h"
#include "engine/shading/image_difference.h"
#include "tests/support/worlds.h"

namespace ff::frame {
namespace {

constexpr int kWidth = 320, kHeight = 200;

double psnr_db(const shading::Image& a, const shading::Image& b) {
    return shading::compare_images(a, b, 0).psnr_db;
}

/// A city or a wood whose sun casts shadows.
class SunShadowsTest : public testing::TestWithParam<bool> {
  protected:
    SunShadowsTest()
        : data(GetParam() ? test::make_city({.cells = 4})
                          : test::make_forest({.trees = 60, .size_m = 80.0, .leaves = 100})) {
        data.environment.sun_shadows = true;
        scene = data.view();
    }

    scene::SceneData data;
    scene::StaticScene scene;
};

Camera walker(int frame) {
    Camera camera{.position = {2.0, 1.7, 3.0}, .yaw = 0.3 + 0.01 * frame};
    camera.position += world_from_camera(camera) * DVec3(0.0, 0.0, -0.04 * frame);
    return camera;
}

TEST_P(SunShadowsTest, reused_light_is_that_of_a_ray_each) {
    Casters casters(scene);
    Renderer reusing(scene, casters, nullptr, kWidth, kHeight), casting(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    std::uint64_t reused = 0, rays = 0, all_rays = 0;
    for (int f = 0; f < 40; ++f) {
        const FrameStats& stats = reusing.draw(walker(f), {}, {.mode = Mode::beam_reuse}, image);
        const FrameStats& all = casting.draw(walker(f), {}, {.mode = Mode::beam}, reference);
        EXPECT_EQ(all.sun_reused, 0u);
        EXPECT_GE(psnr_db(image, reference), 38.0) << "frame " << f;
        if (f == 0) {
            EXPECT_EQ(stats.sun_reused, 0u);
            EXPECT_EQ(psnr_db(image, reference), psnr_db(reference, reference));
            continue;
        }
        reused += stats.sun_reused;
        rays += stats.sun_rays;
        all_rays += all.sun_rays;
    }
    if (GetParam()) {
        EXPECT_GT(reused, rays) << "most is reused";
        EXPECT_LT(rays, all_rays / 2);
    } else {
        // Between leaves much changes.
        EXPECT_GT(reused, 0u);
        EXPECT_LT(rays, all_rays);
        EXPECT_GT(rays, all_rays / 4);
    }
}

TEST_P(SunShadowsTest, who_rests_casts_only_what_is_due) {
    Casters casters(scene);
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    for (const int refresh : {32, 0}) {
        renderer.reset();
        const FrameSettings settings{.mode = Mode::beam_reuse, .sun_refresh_frames = refresh};
        const std::uint64_t first = renderer.draw(walker(0), {}, settings, image).sun_rays;
        ASSERT_GT(first, 1000u);
        for (int f = 0; f < 4; ++f)
            EXPECT_LE(renderer.draw(walker(0), {}, settings, image).sun_rays, refresh == 0 ? 0u : first / 16);
    }
}

TEST_P(SunShadowsTest, every_mode_that_casts_draws_the_same_shadows) {
    Casters casters(scene);
    Renderer raycast(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    for (const Mode mode : {Mode::hybrid, Mode::beam, Mode::beam_reuse, Mode::reproject, Mode::irsa}) {
        Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
        for (int f = 0; f < 12; ++f) {
            // Walks, then turns on the spot: the panorama has shadows, too.
            Camera camera = walker(std::min(f, 5));
            camera.yaw += 0.05 * std::max(0, f - 5);
            renderer.draw(camera, {}, {.mode = mode, .fixed_near_m = 0.0}, image);
            raycast.draw(camera, {}, {.mode = Mode::raycast}, reference);
            // Light between the wood's leaves changes from pixel to pixel: what comes from other rays is noise there.
            const double least_db = mode == Mode::hybrid ? 32.0 : 34.0, noise_db = GetParam() ? 0.0 : 4.0;
            EXPECT_GE(psnr_db(image, reference), least_db - noise_db) << "mode " << int(mode) << ", frame " << f;
        }
    }
}

TEST_P(SunShadowsTest, edges_of_the_panorama_keep_its_light) {
    Casters casters(scene);
    Renderer reusing(scene, casters, nullptr, kWidth, kHeight), casting(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    std::uint64_t reused = 0, rays = 0, all_rays = 0;
    for (int f = 0; f < 40; ++f) {
        Camera camera = walker(0);
        camera.yaw += 0.02 * f;
        const FrameSettings settings{.mode = Mode::hybrid, .fixed_near_m = 0.0, .deterministic = true};
        const FrameStats& stats = reusing.draw(camera, {}, settings, image);
        FrameSettings each = settings;
        each.reuse_sun = false;
        const FrameStats& all = casting.draw(camera, {}, each, reference);
        EXPECT_EQ(all.sun_reused, 0u);
        EXPECT_GE(stats.sun_rays + stats.sun_reused, all.sun_rays) << "whose light is not known is cast";
        // Between leaves light changes within a texel.
        EXPECT_GE(psnr_db(image, reference), GetParam() ? 38.0 : 34.0) << "frame " << f;
        if (stats.pixels.panorama == 0) continue;
        reused += stats.sun_reused;
        rays += stats.sun_rays;
        all_rays += all.sun_rays;
    }
    // Most edges take their texels' colour, light and all; in a city none is left to ask for light alone.
    const bool is_city = GetParam();
    EXPECT_LE(rays, all_rays);
    if (!is_city) {
        EXPECT_GT(reused, 0u);
        EXPECT_LT(rays, all_rays);
    }
}

TEST_P(SunShadowsTest, the_number_of_workers_changes_nothing) {
    std::vector<ZeroPageVector<std::uint32_t>> images;
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        Casters casters(scene);
        Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
        shading::Image image;
        for (int f = 0; f < 8; ++f) renderer.draw(walker(f), {}, {.fixed_near_m = 0.0, .deterministic = true}, image);
        images.push_back(image.pixels);
    }
    EXPECT_EQ(images[0], images[1]);
}

TEST_P(SunShadowsTest, what_is_drawn_after_a_reset_takes_the_same_work_and_no_memory) {
    Casters casters(scene);
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    for (const Mode mode : {Mode::hybrid, Mode::beam_reuse, Mode::reproject}) {
        std::vector<FrameStats> first;
        for (int lap = 0; lap < 3; ++lap) {
            renderer.reset();
            // Not a multiple of the frames in which light is cast anew: laps begin at another point of that cycle.
            for (int f = 0; f < 7; ++f) {
                const FrameStats& stats =
                    renderer.draw(walker(f), {}, {.mode = mode, .fixed_near_m = 0.0, .deterministic = true}, image);
                if (lap == 0) {
                    first.push_back(stats);
                    continue;
                }
                EXPECT_EQ(stats.rays, first[std::size_t(f)].rays) << "mode " << int(mode) << ", frame " << f;
                EXPECT_EQ(stats.sun_rays, first[std::size_t(f)].sun_rays) << "mode " << int(mode) << ", frame " << f;
            }
        }
    }
}

TEST_P(SunShadowsTest, without_them_nothing_is_made_and_no_ray_is_cast) {
    Casters casters(scene);
    shading::Image image;
    for (const auto off : {0, 1, 2}) {
        scene::StaticScene other = scene;
        if (off == 0) other.environment.sun_shadows = false;
        if (off == 1) other.environment.sun_radiance = Vec3(0.0f);
        Renderer renderer(other, casters, nullptr, kWidth, kHeight);
        FrameSettings settings;
        if (off == 2) settings.sun_shadows = SunShadows::off;
        for (int f = 0; f < 3; ++f) {
            const FrameStats& stats = renderer.draw(walker(f), {}, settings, image);
            EXPECT_EQ(stats.sun_rays, 0u);
            EXPECT_EQ(stats.ms(Pass::sun), 0.0);
        }
        EXPECT_EQ(renderer.history().sun, nullptr);
    }
}

INSTANTIATE_TEST_SUITE_P(worlds, SunShadowsTest, testing::Bool(),
                         [](const auto& world) { return std::string(world.param ? "city" : "wood"); });

/// A floor, and a board 10 m above it that moves.
struct BoardOverFloor {
    scene::SceneData data = test::make_single_triangle({-40, 0, 40}, {40, 0, 40}, {0, 0, -80});
    scene::StaticScene scene = data.view();
    scene::Instance board = scene.instances[0];

    BoardOverFloor() {
        scene.environment.to_sun = Vec3(0.0f, 1.0f, 0.0f);
        scene.environment.sun_shadows = true;
        for (int k = 0; k < 3; ++k) board.world_from_mesh[k] *= 0.05f;
    }
    scene::Instance board_at(double x, double z) {
        scene::Instance at = board;
        const WorldPos to(x, 10.0, z);
        at.bounds = {to + DVec3(-2.1, -0.1, -4.1), to + DVec3(2.1, 0.1, 2.1)};
        at.position = to;
        return at;
    }
};

TEST(sun_shadows, what_moves_takes_its_shadow_along_and_leaves_none_behind) {
    BoardOverFloor world;
    Casters casters(world.scene);
    for (const Mode mode : {Mode::hybrid, Mode::beam_reuse}) {
        Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
        Renderer fresh(world.scene, casters, nullptr, kWidth, kHeight);
        shading::Image image, reference, empty;
        const Camera camera{.position = {0.0, 4.0, 14.0}, .pitch = -0.25};
        for (int f = 0; f < 12; ++f) {  // the viewer stands: the panorama would answer all but the shadow
            const scene::Instance board = world.board_at(-3.0 + 0.5 * f, 0.0);
            renderer.draw(camera, std::span(&board, 1), {.mode = mode, .fixed_near_m = 0.0}, image);
            fresh.draw(camera, std::span(&board, 1), {.mode = Mode::raycast}, reference);
            EXPECT_GE(psnr_db(image, reference), 36.0) << "mode " << int(mode) << ", frame " << f;
        }
        // It was there, and is gone with the board.
        fresh.draw(camera, {}, {.mode = Mode::raycast}, empty);
        EXPECT_LT(psnr_db(reference, empty), 36.0);
        renderer.draw(camera, {}, {.mode = mode, .fixed_near_m = 0.0}, image);
        EXPECT_GE(psnr_db(image, empty), 36.0) << "mode " << int(mode);
    }
}

TEST(sun_shadows, a_sun_that_moves_is_followed_at_once) {
    BoardOverFloor world;
    const scene::Instance board = world.board_at(0.0, 0.0);
    Casters casters(world.scene);
    Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference;
    const Camera camera{.position = {0.0, 4.0, 14.0}, .pitch = -0.25};
    const auto draw = [&] {
        renderer.draw(camera, std::span(&board, 1), {.mode = Mode::beam_reuse}, image);
        Renderer fresh(world.scene, casters, nullptr, kWidth, kHeight);
        fresh.draw(camera, std::span(&board, 1), {.mode = Mode::beam}, reference);
        return psnr_db(image, reference);
    };
    EXPECT_GE(draw(), 60.0);
    const shading::Image before = image;
    world.scene.environment.to_sun = Vec3(0.28f, 0.96f, 0.0f);
    EXPECT_GE(draw(), 60.0);
    EXPECT_LT(psnr_db(image, before), 40.0) << "the shadow has moved";
}

}  // namespace
}  // namespace ff::frame
