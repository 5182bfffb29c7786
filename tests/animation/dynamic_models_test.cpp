// Animated models in frames: what each mode draws is the same, and what cannot be seen is not computed.

#include "engine/animation/dynamic_models.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "engine/core/jobs.h"
#include "engine/frame/renderer.h"
#include "engine/gl/device.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/platform/headless.h"
#include "engine/shading/image_difference.h"
#include "tests/support/animated_worlds.h"

namespace ff::animation {
namespace {

constexpr int kWidth = 240, kHeight = 180;

class DynamicModelsTest : public testing::Test {
  protected:
    explicit DynamicModelsTest(const test::AnimatedWorldSettings& settings = {})
        : world(test::make_animated_world(settings)),
          models(*world),
          states(initial_models(world->info().animation)),
          camera{.position = settings.origin + DVec3(1.0, 2.5, 14.0)} {}

    std::span<const scene::Instance> pose_at(double time_s, const PoseSettings& settings = {.max_shift_px = 0.0f}) {
        set_time(world->info().animation, time_s, states);
        return models.pose(states, make_view(camera, kWidth, kHeight), settings);
    }

    shading::Image draw(frame::Mode mode, std::span<const scene::Instance> dynamic,
                        nearfield::NearRenderer* near_renderer = nullptr, std::optional<double> near_m = std::nullopt) {
        frame::Casters casters(world->scene());
        frame::Renderer renderer(world->scene(), casters, near_renderer, kWidth, kHeight);
        shading::Image image;
        frame::FrameSettings settings{.mode = mode};
        settings.fixed_near_m = near_m;
        renderer.draw(camera, dynamic, settings, image);
        EXPECT_TRUE(renderer.refusal());
        return image;
    }

    std::unique_ptr<scene::World> world;
    DynamicModels models;
    std::vector<ModelState> states;
    Camera camera;
};

double psnr_db(const shading::Image& a, const shading::Image& b) {
    return shading::compare_images(a, b, 0).psnr_db;
}

TEST_F(DynamicModelsTest, casters_agree_on_posed_models_and_their_shadows) {
    const auto dynamic = pose_at(0.7);
    EXPECT_EQ(models.stats().skins, 5u);
    EXPECT_EQ(models.stats().posed, 5u);
    const shading::Image raycast = draw(frame::Mode::raycast, dynamic);
    EXPECT_GT(psnr_db(draw(frame::Mode::beam, dynamic), raycast), 45.0);
    EXPECT_GT(psnr_db(draw(frame::Mode::hybrid, dynamic, nullptr, 0.0), raycast), 45.0);
    EXPECT_LT(psnr_db(draw(frame::Mode::raycast, {}), raycast), 32.0) << "the models are in the picture";
}

TEST_F(DynamicModelsTest, the_rasteriser_draws_what_rays_find) {
    auto context = platform::HeadlessContext::open();
    if (!context) GTEST_SKIP() << context.error().message;
    auto near_renderer = nearfield::NearRenderer::make(world->scene());
    ASSERT_TRUE(near_renderer) << near_renderer.error().message;
    for (const double time_s : {0.2, 1.3}) {  // the second finds other vertices in the same buffers
        const auto dynamic = pose_at(time_s);
        const shading::Image rays = draw(frame::Mode::hybrid, dynamic, nullptr, 0.0);
        EXPECT_GT(psnr_db(draw(frame::Mode::hybrid, dynamic, &*near_renderer, 100.0), rays), 35.0) << time_s;
    }
}

TEST_F(DynamicModelsTest, time_moves_models_and_a_loop_comes_back) {
    const shading::Image start = draw(frame::Mode::beam, pose_at(0.0));
    const shading::Image later = draw(frame::Mode::beam, pose_at(0.9));
    const shading::Image again = draw(frame::Mode::beam, pose_at(4.0));  // two bends, one roll
    EXPECT_LT(psnr_db(start, later), 40.0);
    EXPECT_GT(psnr_db(start, again), 50.0);
}

TEST_F(DynamicModelsTest, the_number_of_workers_changes_nothing) {
    std::vector<scene::Instance> two;
    std::vector<Vec3> positions;
    {
        const auto dynamic = pose_at(0.35);
        two.assign(dynamic.begin(), dynamic.end());
        positions.assign(world->scene().positions.begin(), world->scene().positions.end());
    }
    const auto other = test::make_animated_world();
    DynamicModels alone(*other);
    const WorkerLimit one(1);
    set_time(other->info().animation, 0.35, states);
    const auto dynamic = alone.pose(states, make_view(camera, kWidth, kHeight), {.max_shift_px = 0.0f});
    ASSERT_EQ(dynamic.size(), two.size());
    for (std::size_t i = 0; i < two.size(); ++i) {
        EXPECT_EQ(dynamic[i].mesh, two[i].mesh);
        EXPECT_EQ(dynamic[i].position, two[i].position);
        EXPECT_EQ(dynamic[i].bounds.low, two[i].bounds.low);
    }
    EXPECT_TRUE(std::equal(positions.begin(), positions.end(), other->scene().positions.begin()));
}

TEST_F(DynamicModelsTest, what_is_behind_the_viewer_is_not_computed) {
    camera.position.z = -60.0;  // all is at his back, the shadows too
    EXPECT_TRUE(pose_at(0.5).empty());
    EXPECT_EQ(models.stats().posed, 0u);
    EXPECT_EQ(models.stats().models, 8u);
}

TEST_F(DynamicModelsTest, a_shadow_alone_brings_its_model_along) {
    // Looks at the ground beside the worms, where their shadows fall.
    camera = {.position = {0.0, 1.5, 0.0}, .yaw = 0.0, .pitch = -1.2, .vertical_fov = 0.6};
    states.resize(1);
    states[0] = {.position = {1.6, 1.0, 0.4}, .animator = {.model = 0, .now = {.clip = 0}}};
    const auto dynamic = models.pose(states, make_view(camera, kWidth, kHeight));
    ASSERT_EQ(dynamic.size(), 1u);
    EXPECT_LT(psnr_db(draw(frame::Mode::beam, dynamic), draw(frame::Mode::beam, {})), 40.0);
}

TEST_F(DynamicModelsTest, old_poses_shift_by_less_than_is_allowed) {
    constexpr double kDistance = 2000.0;
    camera.position.z = kDistance;
    camera.vertical_fov = 0.1;
    const float allowed_px = 0.25f;
    const double pixel = double(make_view(camera, kWidth, kHeight).pixel_angle());
    std::uint32_t posed = 0;
    for (int f = 0; f < 120; ++f) {
        const double time_s = f / 120.0;
        const auto held = pose_at(time_s, {.max_shift_px = allowed_px});
        posed += models.stats().posed;
        ASSERT_FALSE(held.empty());
        std::vector<Vec3> old_vertices;
        for (const scene::Instance& instance : held) {
            const scene::Mesh& mesh = world->scene().meshes[instance.mesh];
            for (std::uint32_t v = 0; v < mesh.vertex_count; ++v)
                old_vertices.push_back(Vec3(instance.position - camera.position) +
                                       instance.world_from_mesh * world->scene().positions[mesh.first_vertex + v]);
        }
        std::size_t next = 0;
        double worst_px = 0.0;
        for (const scene::Instance& instance : pose_at(time_s)) {
            const scene::Mesh& mesh = world->scene().meshes[instance.mesh];
            for (std::uint32_t v = 0; v < mesh.vertex_count; ++v, ++next) {
                ASSERT_LT(next, old_vertices.size());
                const Vec3 now = Vec3(instance.position - camera.position) +
                                 instance.world_from_mesh * world->scene().positions[mesh.first_vertex + v];
                worst_px = std::max(worst_px, double(glm::length(now - old_vertices[next])) / (kDistance * pixel));
            }
        }
        EXPECT_LE(worst_px, double(allowed_px) * 1.1) << "frame " << f;
    }
    EXPECT_LT(posed, 120u * 5u / 2u) << "most frames show poses of earlier ones";
}

TEST_F(DynamicModelsTest, a_fade_ends_where_the_next_clip_is) {
    states.resize(1);
    const scene::AnimatedModel& worm = world->info().animation.models[0];
    Animator& animator = states[0].animator;
    ASSERT_TRUE(play(worm, animator, "stretch", {.fade_s = 0.5f}));
    const auto extent = [&] {
        const auto dynamic = models.pose(states, make_view(camera, kWidth, kHeight));
        return dynamic.empty() ? DVec3(0.0) : dynamic[0].bounds.extent();
    };
    advance(animator, 0.25);
    const double half_way = extent().y;
    advance(animator, 0.75);  // at 1 s the stretch is at its greatest
    EXPECT_NEAR(extent().y, 3.0 * 1.5, 0.01);
    EXPECT_LT(half_way, 4.0);
    const double straight = extent().x;
    // A layer over the upper half alone.
    const std::uint32_t mask = models.add_mask(0, "joint3");
    ASSERT_NE(mask, kNoMask);
    EXPECT_EQ(models.add_mask(0, "no such joint"), kNoMask);
    animator.layer = {.clip = 0};
    animator.layer_weight = 1.0f;
    animator.layer_mask = mask;
    EXPECT_GT(extent().x, straight + 0.1);
}

TEST(DynamicModels, far_from_the_origin_models_are_drawn_as_near_it) {
    const auto image_at = [](const WorldPos& origin) {
        const auto world = test::make_animated_world({.origin = origin});
        DynamicModels models(*world);
        auto states = initial_models(world->info().animation);
        set_time(world->info().animation, 0.6, states);
        const Camera camera{.position = origin + DVec3(1.0, 2.5, 14.0)};
        const auto dynamic = models.pose(states, make_view(camera, kWidth, kHeight));
        frame::Casters casters(world->scene());
        frame::Renderer renderer(world->scene(), casters, nullptr, kWidth, kHeight);
        shading::Image image;
        renderer.draw(camera, dynamic, {.mode = frame::Mode::beam}, image);
        return image;
    };
    EXPECT_GT(psnr_db(image_at(WorldPos(0.0)), image_at(WorldPos(1e6, 0.0, -1e6))), 45.0);
}

TEST(DynamicModels, two_hundred_are_drawn_though_there_are_fewer_poses) {
    const auto world = test::make_animated_world({.worms = 200, .carts = 0, .spacing_m = 0.9});
    DynamicModels models(*world);
    auto states = initial_models(world->info().animation);
    for (std::size_t i = 0; i < states.size(); ++i) states[i].animator.now.time_s += 0.003 * double(i);
    const Camera camera{.position = {0.0, 2.0, 60.0}, .vertical_fov = 1.6};
    const auto dynamic = models.pose(states, make_view(camera, kWidth, kHeight), {.max_shift_px = 0.0f});
    EXPECT_GT(dynamic.size(), 100u);
    EXPECT_EQ(models.stats().posed, scene::kMostPoses);
    EXPECT_EQ(models.stats().borrowed, dynamic.size() - scene::kMostPoses);
}

}  // namespace
}  // namespace ff::animation
