// Blended surfaces near by: panes of glass against what blending by hand gives, whatever draws the frame.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "engine/core/jobs.h"
#include "engine/frame/renderer.h"
#include "engine/shading/image_difference.h"
#include "tests/support/worlds.h"

namespace ff::frame {
namespace {

constexpr int kWidth = 200, kHeight = 150;  // neither is a multiple of a tile

/// A pane across the view, upright; unlit, so that its colour is known.
struct Pane {
    double z;                 ///< metres; the eye stands at z = 0 and looks along -z
    double left, right;       ///< metres
    std::uint32_t color = 0;  ///< of the kColors
};
constexpr double kLow = 0.5, kHigh = 3.0;
const Vec4 kColors[] = {{1.0f, 0.1f, 0.1f, 0.4f}, {0.1f, 1.0f, 0.1f, 0.5f}, {0.1f, 0.2f, 1.0f, 0.6f}};
const std::vector<Pane> kPanes = {
    {-4.0, -2.0, 0.8, 0}, {-6.0, -1.0, 2.0, 1}, {-7.5, -3.0, 1.0, 2}, {-12.0, -2.0, 3.0, 0}};

scene::MeshSource pane_mesh(const Pane& pane, double z) {
    const auto at = [&](double x, double y) { return Vec3(float(x), float(y), float(z)); };
    scene::MeshSource mesh;
    test::append_quad(mesh, at(pane.left, kLow), at(pane.right, kLow), at(pane.right, kHigh), at(pane.left, kHigh),
                      std::uint16_t(1 + pane.color));
    return mesh;
}

/// Boxes between panes on a ground.
scene::SceneData make_panes(std::span<const Pane> panes, const WorldPos& origin = WorldPos(0.0)) {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    for (const Vec4& color : kColors) {
        scene::Material glass = test::plain_material();
        glass.base_color = color;
        glass.flags = scene::kMaterialBlend | scene::kMaterialUnlit | scene::kMaterialDoubleSided;
        data.materials.push_back(glass);
    }
    scene::MeshSource solid;
    test::append_quad(solid, {-40, 0, 40}, {40, 0, 40}, {40, 0, -80}, {-40, 0, -80}, 0);
    test::append_box(solid, {-1.5f, 0, -5.5f}, {-0.7f, 2, -5}, 1, 0);
    test::append_box(solid, {0.5f, 0, -9}, {1.5f, 3, -8}, 1, 0);
    const auto add = [&](scene::MeshSource mesh) {
        data.add_instance(data.add_mesh(prepare_mesh(std::move(mesh), data.materials)), origin, Mat3(1.0f), 0);
    };
    add(std::move(solid));
    for (const Pane& pane : panes) add(pane_mesh(pane, pane.z));
    data.finish(16);
    return data;
}

Camera eye(double yaw = 0.0, const WorldPos& origin = WorldPos(0.0)) {
    return {.position = origin + WorldPos(0.1, 1.6, 0.0), .yaw = yaw};
}

shading::Image draw(const scene::StaticScene& scene, const Camera& camera, const FrameSettings& settings,
                    FrameStats* stats = nullptr, std::span<const scene::Instance> dynamic = {}) {
    Casters casters(scene);
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    const FrameStats& drawn = renderer.draw(camera, dynamic, settings, image);
    if (stats != nullptr) *stats = drawn;
    return image;
}

double encoded(double x) {
    return 255.0 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055);
}

/// The panes blended by hand, from back to front, over a picture without them.
/// @param levels  the most that a channel of a pixel away from edges is off by
/// @param layers  how many panes stand before pixels, of all pixels
void compare_by_hand(std::span<const Pane> panes, const WorldPos& origin, const shading::Image& image, int& levels,
                     std::uint64_t& layers) {
    const scene::SceneData bare = make_panes({}, origin);
    const scene::StaticScene scene = bare.view();
    Casters casters(scene);
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image behind;
    renderer.draw(eye(0.0, origin), {}, {}, behind);
    const PinholeView view = make_view(eye(), kWidth, kHeight);
    const farfield::VisibilityBuffer& visible = renderer.history().visibility;
    levels = 0;
    layers = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const std::size_t at = visible.index(x, y);
            const DVec3 direction(view.direction(x, y));
            double expected[3];
            for (int k = 0; k < 3; ++k) expected[k] = behind.pixels[at] >> 8 * k & 255u;
            bool near_edge = false;
            for (std::size_t i = panes.size(); i-- > 0;) {  // they are written from front to back
                const double depth = -panes[i].z / -direction.z;
                const DVec3 p = view.position + depth * direction;
                const double margin = 2.0 * depth * view.pixel_angle();
                for (const double edge : {p.x - panes[i].left, p.x - panes[i].right, p.y - kLow, p.y - kHigh})
                    near_edge |= std::abs(edge) < margin;
                if (depth >= double(visible.depth[at]) || p.x < panes[i].left || p.x > panes[i].right || p.y < kLow ||
                    p.y > kHigh)
                    continue;
                ++layers;
                const Vec4& color = kColors[panes[i].color];
                for (int k = 0; k < 3; ++k) expected[k] += double(color.a) * (encoded(double(color[k])) - expected[k]);
            }
            for (int k = 0; k < 3 && !near_edge; ++k)
                levels =
                    std::max(levels, int(std::abs(std::round(expected[k]) - int(image.pixels[at] >> 8 * k & 255u))));
        }
}

TEST(Layers, panes_are_blended_from_back_to_front) {
    const scene::SceneData data = make_panes(kPanes);
    for (const Mode mode : {Mode::hybrid, Mode::raycast})
        for (const CasterKind caster : {CasterKind::beam, CasterKind::embree, CasterKind::grid}) {
            FrameStats stats;
            const shading::Image image = draw(data.view(), eye(), {.mode = mode, .caster = caster}, &stats);
            int levels = 0;
            std::uint64_t layers = 0;
            compare_by_hand(kPanes, WorldPos(0.0), image, levels, layers);
            EXPECT_LE(levels, 2) << "mode " << int(mode) << ", caster " << int(caster);
            EXPECT_GT(layers, 10000u);
            EXPECT_NEAR(double(stats.layers), double(layers), 0.01 * double(layers));
        }
}

TEST(Layers, panes_far_from_the_origin_are_blended_as_well) {
    const WorldPos origin(1.0e6, 50.0, -3.0e6);
    const scene::SceneData data = make_panes(kPanes, origin);
    const shading::Image image = draw(data.view(), eye(0.0, origin), {});
    int levels = 0;
    std::uint64_t layers = 0;
    compare_by_hand(kPanes, origin, image, levels, layers);
    EXPECT_LE(levels, 3);
}

TEST(Layers, a_moving_pane_looks_like_one_that_stands) {
    const scene::SceneData standing = make_panes(kPanes);
    // The second pane is put in its place by its instance.
    scene::SceneData data = make_panes(kPanes);
    std::vector<scene::Instance> moving(data.instances.begin() + 2, data.instances.begin() + 3);
    const DVec3 step(0.0, 0.0, 500.0);
    data.instances[2].position += step;
    data.instances[2].bounds.low += step, data.instances[2].bounds.high += step;
    data.finish(16);
    FrameStats stats;
    const shading::Image image = draw(data.view(), eye(), {}, &stats, moving);
    const shading::Image expected = draw(standing.view(), eye(), {});
    EXPECT_EQ(shading::compare_images(image, expected, 1).wrong_pixels, 0.0);
}

TEST(Layers, a_turning_viewer_sees_layers_over_the_panorama) {
    const scene::SceneData data = make_panes(kPanes);
    const scene::StaticScene scene = data.view();
    Casters casters(scene);
    Renderer hybrid(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    for (int f = 0; f < 20; ++f) {
        const FrameStats& stats = hybrid.draw(eye(0.02 * f), {}, {}, image);
        EXPECT_GT(stats.layers, 1000u);
        if (f > 3) {
            EXPECT_GT(stats.pixels.panorama, 1000u);
        }
        const shading::Image reference = draw(scene, eye(0.02 * f), {.mode = Mode::raycast});
        EXPECT_GE(shading::compare_images(image, reference, 0).psnr_db, 34.0) << "frame " << f;
    }
}

TEST(Layers, another_distance_forgets_what_the_panorama_holds) {
    const scene::SceneData data = make_panes(kPanes);
    const scene::StaticScene scene = data.view();
    Casters casters(scene);
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    for (int f = 0; f < 6; ++f) renderer.draw(eye(0.02 * f), {}, {.blend_within_m = 0.0f}, image);
    renderer.draw(eye(0.12), {}, {}, image);
    const shading::Image reference = draw(scene, eye(0.12), {.mode = Mode::raycast});
    EXPECT_GE(shading::compare_images(image, reference, 0).psnr_db, 34.0);
}

TEST(Layers, no_worker_changes_a_pixel) {
    const scene::SceneData data = make_panes(kPanes);
    shading::Image images[2];
    FrameStats stats[2];
    for (int i = 0; i < 2; ++i) {
        const WorkerLimit limit(i + 1);
        images[i] = draw(data.view(), eye(), {.deterministic = true}, &stats[i]);
    }
    EXPECT_EQ(images[0].pixels, images[1].pixels);
    EXPECT_EQ(stats[0].layers, stats[1].layers);
}

TEST(Layers, a_pixel_with_thousands_of_layers_is_still_right) {
    // More than a tile has room for: its pixels are answered in parts.
    std::vector<Pane> panes;
    for (int i = 0; i < 60; ++i) panes.push_back({-4.0 - 0.05 * i, -3.0, 3.0, std::uint32_t(i % 3)});
    scene::SceneData data = make_panes(panes);
    for (scene::Material& material : data.materials)
        if ((material.flags & scene::kMaterialBlend) != 0) material.base_color.a = 0.02f;
    FrameStats stats;
    const shading::Image image = draw(data.view(), eye(), {}, &stats);
    EXPECT_GT(stats.layers, 300000u);
    // Between neighbours in a pane nothing jumps, as it would where a part of a tile went missing.
    const int row = kHeight / 2 - 20;
    for (int x = 40; x < 150; ++x) {
        const std::uint32_t a = image.pixels[std::size_t(row * image.stride + x)];
        const std::uint32_t b = image.pixels[std::size_t(row * image.stride + x + 1)];
        if (x % farfield::kTileSize != farfield::kTileSize - 1) continue;
        for (int k = 0; k < 24; k += 8) EXPECT_LE(std::abs(int(a >> k & 255u) - int(b >> k & 255u)), 24) << "x " << x;
    }
}

TEST(Layers, coverage_and_sorting_have_the_same_mean_colour) {
    const scene::SceneData data = make_panes(kPanes);
    const Camera camera{.position = {0.0, 1.7, -2.0}, .vertical_fov = 0.3};
    const shading::Image sorted = draw(data.view(), camera, {.use_panorama = false});
    const shading::Image covered = draw(data.view(), camera, {.blend_within_m = 0.0f, .use_panorama = false});
    double difference[3] = {};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int k = 0; k < 3; ++k) {
                const auto at = std::size_t(y * sorted.stride + x);
                difference[k] += double(sorted.pixels[at] >> 8 * k & 255u) - double(covered.pixels[at] >> 8 * k & 255u);
            }
    for (const double d : difference) EXPECT_LT(std::abs(d) / (kWidth * kHeight), 4.0);
    EXPECT_LT(shading::compare_images(sorted, covered, 0).psnr_db, 30.0);  // else the comparison would say nothing
}

TEST(Layers, beyond_their_distance_there_are_none) {
    const scene::SceneData data = make_panes(kPanes);
    FrameStats stats;
    draw(data.view(), eye(), {.blend_within_m = 0.0f}, &stats);
    EXPECT_EQ(stats.layers, 0u);
    draw(data.view(), eye(), {.blend_within_m = 3.0f}, &stats);
    EXPECT_EQ(stats.layers, 0u);
    draw(data.view(), eye(), {.blend_within_m = 5.0f}, &stats);
    EXPECT_GT(stats.layers, 1000u);
    const scene::SceneData bare = make_panes({});
    draw(bare.view(), eye(), {}, &stats);
    EXPECT_EQ(stats.ms(Pass::blend), 0.0);
}

TEST(Layers, frames_drawn_smaller_have_them) {
    const scene::SceneData data = make_panes(kPanes);
    const scene::StaticScene scene = data.view();
    Casters casters(scene);
    Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
    shading::Image image;
    bool was_smaller = false;
    for (int f = 0; f < 40 && !was_smaller; ++f) {
        Camera camera = eye();
        camera.position.x += 0.01 * f;
        const FrameStats& stats = renderer.draw(camera, {}, {.budget_ms = 0.05}, image);
        was_smaller = stats.resolution < 1.0;
        EXPECT_GT(stats.layers, 100u);
    }
    EXPECT_TRUE(was_smaller);
}

}  // namespace
}  // namespace ff::frame
