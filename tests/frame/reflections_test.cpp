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

TEST(reflections, far_water_rests_in_the_panorama_with_what_it_mirrors) {
    LakeWorld world;
    world.data.materials[1].alpha_cutoff = 1.0f;  // waves
    Casters casters(world.scene);
    const auto settings_at = [](float within_m, int frame) {
        return FrameSettings{.fixed_near_m = 0.0, .time_s = 0.3 * frame, .water_within_m = within_m};
    };
    std::uint64_t shaded[2] = {};
    for (const bool is_far : {false, true}) {
        Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
        Renderer fresh(world.scene, casters, nullptr, kWidth, kHeight);
        shading::Image image, before, reference, sky_only;
        double least_db = 99.0;
        for (int f = 0; f < 12; ++f) {
            // Nearer than 5 m the lake has waves, which take no part in what is compared far away.
            FrameSettings settings = settings_at(is_far ? 5.0f : 1500.0f, f);
            const FrameStats& stats = renderer.draw(kOnShore, {}, settings, image);
            EXPECT_TRUE(stats.effects.is_active(effects::EffectId::water));
            if (f > 6) shaded[is_far] += stats.shaded_pixels - stats.pixels.sky;
            if (f > 6) least_db = std::min(least_db, shading::compare_images(image, before, 0).psnr_db);
            before = image;
            settings.mode = Mode::raycast;
            fresh.draw(kOnShore, {}, settings, reference);
            EXPECT_GE(shading::compare_images(image, reference, 0).psnr_db, is_far ? 30.0 : 26.0) << f;
        }
        // The image of the wall lies on the lake, far as it is.
        fresh.draw(kOnShore, {}, {.mode = Mode::raycast, .time_s = 3.3, .reflection_rays = 0}, sky_only);
        EXPECT_LT(channel(image, kWidth / 2, 140, 2), channel(sky_only, kWidth / 2, 140, 2) - 40) << is_far;
        if (is_far) {
            EXPECT_GT(least_db, 40.0) << "what rests stands still";
        } else {
            EXPECT_LT(least_db, 40.0) << "waves move";
        }
    }
    EXPECT_LT(shaded[1], shaded[0] / 2);
}

/// A polished wall before the viewer, and a red one behind him that it shows.
struct MirrorWorld {
    MirrorWorld() {
        scene::Material polished = test::plain_material(), wall = test::plain_material();
        polished.base_color = {0.8f, 0.8f, 0.8f, 1.0f};
        polished.metallic = 1.0f;
        polished.roughness = 0.05f;
        polished.flags = scene::kMaterialSpecular | scene::kMaterialMirror;
        wall.base_color = {0.7f, 0.03f, 0.03f, 1.0f};
        data.materials = {test::plain_material(), polished, wall};
        scene::MeshSource mesh, board;
        test::append_quad(mesh, {-60, 0, 60}, {60, 0, 60}, {60, 0, -60}, {-60, 0, -60}, 0);
        test::append_quad(mesh, {-8, 0.5, -12}, {8, 0.5, -12}, {8, 7, -12}, {-8, 7, -12}, 1);
        test::append_quad(mesh, {6, 0, 15}, {-6, 0, 15}, {-6, 3, 15}, {6, 3, 15}, 2);
        test::append_quad(board, {2, 0, 0}, {-2, 0, 0}, {-2, 5, 0}, {2, 5, 0}, 2);
        data.add_instance(data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials)), WorldPos(0.0),
                          Mat3(1.0f), 0);
        data.add_instance(data.add_mesh(scene::prepare_mesh(std::move(board), data.materials)),
                          WorldPos(0.0, 0.0, 200.0), Mat3(1.0f), 0);
        data.finish(64);
        scene = data.view();
    }
    /// A red board that the mirror may show, anywhere.
    [[nodiscard]] scene::Instance board_at(double x, double z) const {
        scene::Instance board = scene.instances[1];
        const DVec3 to = DVec3(x, 0.0, z) - board.position;
        board.position += to;
        board.bounds = {board.bounds.low + to, board.bounds.high + to};
        return board;
    }
    scene::SceneData data;
    scene::StaticScene scene;
};

Camera turned(int frame) {
    return {.position = {0.0, 2.0, 0.0}, .yaw = 0.02 * frame};
}

double redness(const shading::Image& image, int x0, int y0, int x1, int y1) {
    double sum = 0.0;
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) sum += channel(image, x, y, 0) - channel(image, x, y, 1);
    return sum / ((x1 - x0) * (y1 - y0));
}

TEST(reflections, who_turns_sees_mirrors_that_were_shaded_once) {
    MirrorWorld world;
    Casters casters(world.scene);
    Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
    Renderer fresh(world.scene, casters, nullptr, kWidth, kHeight);
    Renderer dull(world.scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference, without;
    std::uint64_t shaded = 0, shaded_without = 0;
    for (int f = 0; f < 12; ++f) {
        shaded += renderer.draw(turned(f), {}, {.fixed_near_m = 0.0}, image).shaded_pixels;
        shaded_without += dull.draw(turned(f), {}, {.fixed_near_m = 0.0, .reflection_rays = 0}, without).shaded_pixels;
        fresh.draw(turned(f), {}, {.mode = Mode::raycast}, reference);
        EXPECT_GE(shading::compare_images(image, reference, 0).psnr_db, 34.0) << f;
    }
    // The red wall is there, and hardly a pixel more was shaded for it.
    EXPECT_GT(redness(image, 100, 117, 130, 125), redness(without, 100, 117, 130, 125) + 30.0);
    EXPECT_LT(shaded, shaded_without + shaded_without / 20);
}

TEST(reflections, what_moves_in_a_mirror_is_followed_and_leaves_nothing_behind) {
    MirrorWorld world;
    Casters casters(world.scene);
    Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
    Renderer fresh(world.scene, casters, nullptr, kWidth, kHeight);
    shading::Image image, reference, without;
    for (int f = 0; f < 20; ++f) {
        const scene::Instance board = world.board_at(-5.0 + 0.5 * f, 8.0);
        renderer.draw(turned(0), std::span(&board, 1), {.fixed_near_m = 0.0}, image);
        fresh.draw(turned(0), std::span(&board, 1), {.mode = Mode::raycast}, reference);
        EXPECT_GE(shading::compare_images(image, reference, 0).psnr_db, 34.0) << f;
    }
    renderer.draw(turned(0), {}, {.fixed_near_m = 0.0}, image);
    fresh.draw(turned(0), {}, {.mode = Mode::raycast}, without);
    EXPECT_LT(shading::compare_images(reference, without, 0).psnr_db, 34.0) << "it was to be seen";
    EXPECT_GE(shading::compare_images(image, without, 0).psnr_db, 34.0);
}

TEST(reflections, mirrors_forget_what_has_changed_wherever_it_stands) {
    MirrorWorld world;
    Casters casters(world.scene);
    Renderer renderer(world.scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    for (int f = 0; f < 4; ++f) renderer.draw(turned(0), {}, {.fixed_near_m = 0.0}, image);
    const double before = redness(image, 130, 117, 190, 127);
    world.data.materials[2].base_color = {0.5f, 0.5f, 0.5f, 1.0f};
    renderer.region_changed({DVec3(-6.0, 0.0, 14.9), DVec3(6.0, 3.0, 15.1)});
    for (int f = 0; f < 2; ++f) renderer.draw(turned(0), {}, {.fixed_near_m = 0.0}, image);
    EXPECT_LT(redness(image, 130, 117, 190, 127), before - 20.0);
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
