// Water and glass through whole frames: what they mirror, what that costs, and that the picture moves smoothly.

#include <gtest/gtest.h>

#include <cmath>

#include "engine/core/jobs.h"
#include "engine/frame/renderer.h"
#include "engine/shading/image_difference.h"
#include "tests/support/worlds.h"

namespace ff::frame {
namespace {

constexpr int kWidth = 320, kHeight = 240;

int channel(const shading::Image& image, int x, int y, int k) {
    return int(image.pixels[std::size_t(y) * std::size_t(image.stride) + std::size_t(x)] >> 8 * k & 255u);
}

/// A lake, and a red wall on its far shore.
struct LakeWorld {
    LakeWorld() {
        scene::Material water = test::plain_material(), wall = test::plain_material();
        water.base_color = {0.02f, 0.05f, 0.06f, 1.0f};
        water.roughness = 0.08f;
        water.alpha_cutoff = 0.0f;  // no waves
        water.flags = scene::kMaterialSpecular | scene::kMaterialWater;
        wall.base_color = {0.7f, 0.03f, 0.03f, 1.0f};
        data.materials = {test::plain_material(), water, wall};
        scene::MeshSource mesh;
        test::append_quad(mesh, {-60, 0, 5}, {60, 0, 5}, {60, 0, -60}, {-60, 0, -60}, 1);
        test::append_quad(mesh, {-60, -3, 5}, {60, -3, 5}, {60, -3, -60}, {-60, -3, -60}, 0);  // its bed
        test::append_quad(mesh, {-20, -3, -40}, {20, -3, -40}, {20, 12, -40}, {-20, 12, -40}, 2);
        data.add_instance(data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials)), WorldPos(0.0),
                          Mat3(1.0f), 0);
        data.finish(64);
        scene = data.view();
    }
    scene::SceneData data;
    scene::StaticScene scene;
};

const Camera kOnShore{.position = {0.0, 2.0, 4.0}, .pitch = -0.05};

TEST(reflections, still_water_shows_what_stands_behind_it_upside_down) {
    LakeWorld world;
    Casters casters(world.scene);
    Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, sky_only;
    for (const Mode mode : {Mode::hybrid, Mode::beam, Mode::raycast, Mode::reproject}) {
        renderer.reset();
        const FrameStats& stats = renderer.draw(kOnShore, {}, {.mode = mode}, image);
        EXPECT_TRUE(stats.effects.is_active(effects::EffectId::reflections));
        EXPECT_GT(stats.work(effects::EffectId::reflections).rays, 1000u);
        renderer.draw(kOnShore, {}, {.mode = mode, .reflection_rays = 0}, sky_only);
        // A few pixels below the foot of the wall its image begins; far below it is sky again.
        const int x = kWidth / 2, near_foot = 140;
        EXPECT_GT(channel(image, x, near_foot, 0), channel(image, x, near_foot, 2) + 20) << int(mode);
        EXPECT_LT(channel(sky_only, x, near_foot, 0), channel(sky_only, x, near_foot, 2) + 5) << int(mode);
    }
}

TEST(reflections, fewer_rays_give_nearly_the_same_picture) {
    LakeWorld world;
    Casters casters(world.scene);
    Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
    shading::Image all, some;
    renderer.draw(kOnShore, {}, {.reflection_rays = 1'000'000}, all);
    renderer.draw(kOnShore, {}, {.reflection_rays = 1'000'000}, all);  // the finest step is taken by halves
    std::uint64_t last_rays = renderer.history().last_stats.work(effects::EffectId::reflections).rays;
    EXPECT_GT(last_rays, 10'000u);
    double last_db = 99.0;
    for (const std::uint64_t rays : {10'000u, 3'000u, 1'000u}) {
        renderer.reset();
        const FrameStats& stats = renderer.draw(kOnShore, {}, {.reflection_rays = rays}, some);
        EXPECT_LE(stats.work(effects::EffectId::reflections).rays, rays);
        const double db = shading::compare_images(all, some, 0).psnr_db;
        EXPECT_GT(db, 28.0) << rays;
        EXPECT_LE(db, last_db + 0.5) << rays;
        last_db = db;
    }
}

TEST(reflections, the_number_of_workers_changes_nothing_nor_does_a_second_run) {
    LakeWorld world;
    std::vector<std::uint32_t> first;
    for (const int workers : {1, 2, 1}) {
        const WorkerLimit limit(workers);
        Casters casters(world.scene);
        Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
        shading::Image image;
        for (int f = 0; f < 4; ++f)
            renderer.draw({.position = {0.1 * f, 2.0, 4.0}, .pitch = -0.05}, {}, {.deterministic = true}, image);
        const std::vector<std::uint32_t> pixels(image.pixels.begin(), image.pixels.end());
        if (first.empty()) first = pixels;
        EXPECT_EQ(pixels, first) << workers;
    }
}

}  // namespace
}  // namespace ff::frame
