#include "engine/nearfield/near_renderer.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "engine/farfield/ray_caster.h"
#include "engine/scene/sky_table.h"
#include "engine/shading/atmosphere.h"
#include "tests/gl/gl_fixture.h"
#include "tests/support/worlds.h"

namespace ff::nearfield {
namespace {

using farfield::VisibilityBuffer;

constexpr int kWidth = 320, kHeight = 240;

std::vector<std::uint32_t> all_instances(const scene::StaticScene& scene) {
    std::vector<std::uint32_t> ids(scene.instances.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

std::vector<farfield::TileRequest> whole_image(const VisibilityBuffer& buffer) {
    std::vector<farfield::TileRequest> tiles;
    for (int y = 0; y < buffer.height; y += farfield::kTileSize) {
        for (int x = 0; x < buffer.width; x += farfield::kTileSize) {
            farfield::TileRequest tile{.x = std::uint16_t(x), .y = std::uint16_t(y)};
            for (auto& row : tile.rows) row = 0xFFFF;
            tiles.push_back(tile);
        }
    }
    return tiles;
}

struct Difference {
    double other_id = 0.0;      ///< share of pixels with another triangle, or sky instead of one
    double other_inside = 0.0;  ///< of these, such whose four neighbours all agree among the caster's ids
    double median_depth = 0.0, worst_depth = 0.0;  ///< relative, where the ids agree
};

/// What a ray caster and the rasteriser see differently.
Difference compare(const scene::StaticScene& scene, const PinholeView& view) {
    VisibilityBuffer cast, drawn;
    cast.resize(view.width, view.height);
    const auto caster = farfield::make_embree_caster(scene);
    caster->cast_tiles(view, whole_image(cast), cast);
    auto renderer = NearRenderer::make(scene);
    EXPECT_TRUE(renderer) << renderer.error().message;
    if (!renderer) return {};
    NearStats stats;
    const Status drawn_status = renderer->render_ids(view, {.instances = all_instances(scene)}, drawn, stats);
    EXPECT_TRUE(drawn_status);

    Difference result;
    std::vector<double> depth_errors;
    const auto same = [&](std::size_t a, std::size_t b) {
        return cast.instance[a] == cast.instance[b] && cast.triangle[a] == cast.triangle[b];
    };
    int others = 0, inside = 0;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const std::size_t i = cast.index(x, y);
            const std::uint32_t expected =
                cast.instance[i] == farfield::kSkyInstance ? farfield::kUnresolved : cast.instance[i];
            if (drawn.instance[i] == expected &&
                (expected == farfield::kUnresolved || drawn.triangle[i] == cast.triangle[i])) {
                if (expected != farfield::kUnresolved)
                    depth_errors.push_back(std::abs(drawn.depth[i] - cast.depth[i]) / cast.depth[i]);
                continue;
            }
            // Two triangles in one place: either may win.
            if (std::abs(drawn.depth[i] - cast.depth[i]) < 1e-5f * cast.depth[i]) continue;
            ++others;
            const bool border = x == 0 || y == 0 || x == view.width - 1 || y == view.height - 1;
            const auto stride = std::size_t(cast.stride);
            if (!border && same(i, i - 1) && same(i, i + 1) && same(i, i - stride) && same(i, i + stride)) ++inside;
        }
    }
    result.other_id = double(others) / (view.width * view.height);
    result.other_inside = double(inside) / (view.width * view.height);
    if (!depth_errors.empty()) {
        std::sort(depth_errors.begin(), depth_errors.end());
        result.median_depth = depth_errors[depth_errors.size() / 2];
        result.worst_depth = depth_errors.back();
    }
    ::testing::Test::RecordProperty("other_id_ppm", int(1e6 * result.other_id));
    fmt::print(stderr, "other ids {:.5f}, inside {:.6f}, depth median {:.2e} worst {:.2e}\n", result.other_id,
               result.other_inside, result.median_depth, result.worst_depth);
    return result;
}

PinholeView street_view(const WorldPos& origin = WorldPos(0.0), double yaw = 0.4, double pitch = -0.05) {
    return make_view({.position = origin + DVec3(3.0, 1.7, 5.0), .yaw = yaw, .pitch = pitch}, kWidth, kHeight);
}

using NearRendererTest = test::GlTest;

TEST_F(NearRendererTest, ids_are_the_casters_own_except_at_edges_in_a_city) {
    const scene::SceneData world = test::make_city({.cells = 3, .subdivisions = 4});
    const Difference difference = compare(world.view(), street_view());
    EXPECT_LT(difference.other_id, 0.0005);
    EXPECT_EQ(difference.other_inside, 0.0);
    EXPECT_LT(difference.median_depth, 1e-5);
}

TEST_F(NearRendererTest, ids_stay_the_casters_own_a_thousand_kilometres_from_the_origin) {
    const WorldPos origin(1.0e6, 0.0, -1.0e6);
    const scene::SceneData world = test::make_city({.cells = 3, .subdivisions = 4}, {.origin = origin});
    const Difference difference = compare(world.view(), street_view(origin));
    EXPECT_LT(difference.other_id, 0.0005);
    EXPECT_EQ(difference.other_inside, 0.0);
}

TEST_F(NearRendererTest, ids_are_the_casters_own_for_any_camera_in_triangle_soup) {
    const scene::SceneData world = test::make_triangle_soup({.triangles = 200, .meshes = 3});
    test::Random random(7);
    for (int i = 0; i < 4; ++i) {
        const Camera camera = test::random_camera(random, world.bounds);
        SCOPED_TRACE(i);
        const Difference difference = compare(world.view(), make_view(camera, kWidth, kHeight));
        EXPECT_LT(difference.other_id, 0.001);
    }
}

TEST_F(NearRendererTest, masked_leaves_are_where_the_casters_see_them) {
    const scene::SceneData world = test::make_forest({.trees = 100, .size_m = 80.0});
    const Difference difference = compare(world.view(), street_view());
    EXPECT_LT(difference.other_id, 0.002);  // texels' borders: interpolated coordinates differ in their last bits
}

TEST_F(NearRendererTest, terrain_is_seen_alike_to_the_horizon) {
    const scene::SceneData world = test::make_terrain();
    const double ground = test::terrain_height(3.0, 5.0, 80.0);
    const Difference difference = compare(world.view(), street_view({0.0, ground, 0.0}));
    EXPECT_LT(difference.other_id, 0.0005);
}

TEST_F(NearRendererTest, dynamic_instances_appear_under_their_own_ids) {
    const scene::SceneData world = test::make_single_triangle({-1, -1, -5}, {1, -1, -5}, {0, 1, -5});
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    std::vector<scene::Instance> dynamic(1, scene.instances[0]);
    dynamic[0].position += DVec3(0.0, 0.0, 2.0);  // in front of the static one
    const std::uint32_t ids[] = {0, 1};
    VisibilityBuffer buffer;
    NearStats stats;
    ASSERT_TRUE(renderer->render_ids(make_view({}, 64, 64), {.instances = ids, .dynamic = dynamic}, buffer, stats));
    EXPECT_EQ(buffer.instance[buffer.index(32, 32)], 1u);
    EXPECT_NEAR(buffer.depth[buffer.index(32, 32)], 3.0, 1e-4);
    EXPECT_EQ(buffer.instance[buffer.index(0, 0)], farfield::kUnresolved);
    EXPECT_TRUE(std::isinf(buffer.depth[buffer.index(0, 0)]));
    EXPECT_EQ(stats.triangles, 2u);
}

TEST_F(NearRendererTest, an_empty_set_leaves_every_pixel_unresolved) {
    const scene::SceneData world = test::make_empty_world();
    const scene::StaticScene scene = world.view();  // outlives the renderer
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    VisibilityBuffer buffer;
    NearStats stats;
    ASSERT_TRUE(renderer->render_ids(make_view({}, 33, 17), {}, buffer, stats));
    for (int y = 0; y < 17; ++y)
        for (int x = 0; x < 33; ++x) EXPECT_EQ(buffer.instance[buffer.index(x, y)], farfield::kUnresolved);
    shading::Image image;
    EXPECT_TRUE(renderer->render_shaded(make_view({}, 33, 17), {}, image, stats));
}

TEST_F(NearRendererTest, a_view_too_large_for_the_driver_is_refused) {
    const scene::SceneData world = test::make_empty_world();
    const scene::StaticScene scene = world.view();  // outlives the renderer
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    PinholeView view = make_view({}, 16, 16);
    view.width = 1 << 20;
    shading::Image image;
    NearStats stats;
    const Status status = renderer->render_shaded(view, {}, image, stats);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("1048576x16"), std::string::npos);
}

/// Share of pixels where the rasterised picture and the shading pass over the casters' ids differ by more than
/// `tolerance` of 255 in some channel.
double shading_difference(const scene::StaticScene& scene, const PinholeView& view, int tolerance) {
    VisibilityBuffer cast;
    cast.resize(view.width, view.height);
    const auto tiles = whole_image(cast);
    farfield::make_embree_caster(scene)->cast_tiles(view, tiles, cast);
    shading::Image expected, drawn;
    expected.resize(view.width, view.height);
    shading::shade_tiles(scene, {}, view, cast, tiles, {}, expected);
    auto renderer = NearRenderer::make(scene);
    EXPECT_TRUE(renderer) << renderer.error().message;
    if (!renderer) return 1.0;
    NearStats stats;
    EXPECT_TRUE(renderer->render_shaded(view, {.instances = all_instances(scene)}, drawn, stats));
    int others = 0;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const std::uint32_t a = expected.pixels[std::size_t(y * expected.stride + x)];
            const std::uint32_t b = drawn.pixels[std::size_t(y * drawn.stride + x)];
            int worst = 0;
            for (int shift = 0; shift < 24; shift += 8)
                worst = std::max(worst, std::abs(int(a >> shift & 255u) - int(b >> shift & 255u)));
            others += worst > tolerance;
        }
    }
    const double share = double(others) / (view.width * view.height);
    fmt::print(stderr, "shading differs on {:.5f}\n", share);
    return share;
}

TEST_F(NearRendererTest, the_shaded_picture_is_the_shading_passes_except_at_edges_in_a_city) {
    const scene::SceneData world = test::make_city({.cells = 3, .subdivisions = 4});
    EXPECT_LT(shading_difference(world.view(), street_view(), 3), 0.001);
}

TEST_F(NearRendererTest, the_shaded_picture_is_the_shading_passes_except_at_leaves_in_a_forest) {
    const scene::SceneData world = test::make_forest({.trees = 100, .size_m = 80.0});
    EXPECT_LT(shading_difference(world.view(), street_view(), 3), 0.001);
}

/// A floor to the horizon and a wall, of one material.
scene::SceneData make_room(scene::Material material, double fog_density) {
    scene::SceneData world;
    std::vector<std::uint32_t> texels(64 * 64);
    test::Random random(5);
    for (auto& texel : texels) texel = 0xFF000000u | random.below(1u << 24);
    if (material.base_color_texture != scene::kNoTexture) {
        material.base_color_texture = world.add_texture(texels, 64, 64, scene::Wrap::repeat, scene::Wrap::mirror);
        material.metallic_roughness_texture = material.base_color_texture;
    }
    world.materials = {material};
    scene::MeshSource mesh;
    test::append_quad(mesh, {-200, 0, 200}, {200, 0, 200}, {200, 0, -200}, {-200, 0, -200}, 0);
    test::append_quad(mesh, {-4, 0, -9}, {6, 0, -12}, {6, 5, -12}, {-4, 5, -9}, 0);
    for (auto& attributes : mesh.attributes) attributes.uv *= 20.0f;
    world.add_instance(world.add_mesh(scene::prepare_mesh(std::move(mesh), world.materials)), WorldPos(0.0), Mat3(1.0f),
                       0);
    world.environment.fog_density_per_m = float(fog_density);
    world.finish(16);
    return world;
}

TEST_F(NearRendererTest, textures_highlights_and_fog_are_the_shading_passes) {
    scene::Material material = test::plain_material();
    material.base_color_texture = 0;
    const PinholeView view = make_view({.position = {0.5, 1.7, 2.0}, .pitch = -0.1}, kWidth, kHeight);
    {
        const scene::SceneData world = make_room(material, 0.0);
        EXPECT_LT(shading_difference(world.view(), view, 3), 0.005);  // a level of detail may round the other way
    }
    {
        const scene::SceneData world = make_room(material, 0.01);
        EXPECT_LT(shading_difference(world.view(), view, 3), 0.005);
    }
    material.flags |= scene::kMaterialSpecular;
    material.roughness = 0.4f;
    material.metallic = 0.5f;
    const scene::SceneData world = make_room(material, 0.0);
    EXPECT_LT(shading_difference(world.view(), view, 3), 0.005);
}

TEST_F(NearRendererTest, the_air_of_an_atmosphere_is_the_shading_passes) {
    scene::Material material = test::plain_material();
    material.base_color_texture = 0;
    scene::SkyTable table;
    for (const float height : {0.8f, 0.1f, -0.1f}) {
        scene::SceneData world = make_room(material, height > 0.5f ? 0.01 : 0.0);
        world.environment.atmosphere.turbidity = 4.0f;
        world.environment.to_sun = Vec3(0.0f, height, -std::sqrt(1.0f - height * height));
        shading::light_atmosphere(world.environment, table);
        for (const double pitch : {-0.1, 0.4}) {  // the floor; the sun
            const PinholeView view = make_view({.position = {0.5, 1.7, 2.0}, .pitch = pitch}, kWidth, kHeight);
            EXPECT_LT(shading_difference(world.view(), view, 3), 0.005) << height << ", " << pitch;
        }
    }
}

TEST_F(NearRendererTest, every_combination_of_material_features_has_a_program) {
    scene::SceneData world = test::make_single_triangle({-1, -1, -5}, {1, -1, -5}, {0, 1, -5});
    const std::uint32_t texel = 0xFF808080u;
    const std::uint32_t texture =
        world.add_texture(std::span(&texel, 1), 1, 1, scene::Wrap::repeat, scene::Wrap::repeat);
    for (std::uint32_t flags = 0; flags < 32; ++flags) {
        for (std::uint32_t textures = 0; textures < 8; ++textures) {
            scene::Material material;
            material.flags = flags;
            if (textures & 1) material.base_color_texture = texture;
            if (textures & 2) material.emissive_texture = texture;
            if (textures & 4) material.metallic_roughness_texture = texture;
            world.materials.push_back(material);
        }
    }
    for (const float fog : {0.0f, 0.1f}) {
        world.environment.fog_density_per_m = fog;
        world.environment.atmosphere.turbidity = fog > 0.0f ? 2.0f : 0.0f;
        const scene::StaticScene scene = world.view();  // outlives the renderer
        const auto renderer = NearRenderer::make(scene);
        EXPECT_TRUE(renderer) << renderer.error().message;
    }
}

TEST_F(NearRendererTest, blended_triangles_are_where_the_casters_see_them) {
    // Panes with and without textures, every wrap, and opaque triangles between them, so that the GPU's order is not
    // the scene's.
    scene::SceneData world;
    test::Random random(9);
    world.materials.push_back(test::plain_material());
    world.materials.push_back({.base_color = {0.5f, 0.6f, 0.7f, 0.5f}, .flags = scene::kMaterialBlend});
    std::vector<std::uint32_t> texels(32 * 16);
    for (auto& texel : texels) texel = random.below(1u << 24) | random.below(256) << 24;
    for (const auto u : {scene::Wrap::repeat, scene::Wrap::clamp, scene::Wrap::mirror})
        for (const auto v : {scene::Wrap::repeat, scene::Wrap::clamp, scene::Wrap::mirror}) {
            scene::Material material = world.materials[1];
            material.base_color.a = 0.9f;
            material.base_color_texture = world.add_texture(texels, 32, 16, u, v);
            world.materials.push_back(material);
        }
    scene::MeshSource mesh;
    for (int i = 0; i < 60; ++i) {
        const Vec3 at = random.in_box({-8, -6, -24}, {8, 6, -4});
        const Vec3 right = random.in_box({0.5f, -1, -1}, {3, 1, 1}), up = random.in_box({-1, 0.5f, -1}, {1, 3, 1});
        test::append_quad(mesh, at - right - up, at + right - up, at + right + up, at - right + up,
                          std::uint16_t(i % 11));
    }
    for (auto& attributes : mesh.attributes) attributes.uv = attributes.uv * 3.0f - Vec2(1.0f);
    const std::uint32_t id = world.add_mesh(scene::prepare_mesh(std::move(mesh), world.materials));
    world.add_instance(id, WorldPos(0.0), Mat3(1.0f), 0);
    world.add_instance(id, WorldPos(3.0, 1.0, -20.0), test::turned_and_scaled(0.3, {-1.0f, 1.0f, 1.2f}), 0);
    world.finish(16);
    const Difference difference = compare(world.view(), make_view({}, kWidth, kHeight));
    EXPECT_LT(difference.other_id, 0.002);  // texels' borders, as with leaves; by another hash a fifth would differ
}

TEST_F(NearRendererTest, blended_triangles_lie_over_what_is_behind_them) {
    scene::SceneData world;
    world.materials.resize(3);
    world.materials[0] = {.base_color = {1, 0, 0, 1}, .flags = scene::kMaterialUnlit};
    world.materials[1] = {.base_color = {0, 1, 0, 0.5f}, .flags = scene::kMaterialUnlit | scene::kMaterialBlend};
    world.materials[2] = {.base_color = {0, 0, 1, 0.5f}, .flags = scene::kMaterialUnlit | scene::kMaterialBlend};
    const auto add_pane = [&](float z, std::uint16_t material) {
        scene::MeshSource mesh;
        test::append_quad(mesh, {-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, material);
        world.add_instance(world.add_mesh(scene::prepare_mesh(std::move(mesh), world.materials)), WorldPos(0, 0, z),
                           Mat3(1.0f), 0);
    };
    add_pane(-3.0f, 2);  // nearest, named first
    add_pane(-5.0f, 0);
    add_pane(-4.0f, 1);
    add_pane(-6.0f, 1);  // behind the opaque one
    world.finish(16);
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    shading::Image image;
    NearStats stats;
    ASSERT_TRUE(renderer->render_shaded(make_view({}, 32, 32), {.instances = all_instances(scene)}, image, stats));
    const std::uint32_t pixel = image.pixels[std::size_t(16 * image.stride + 16)];
    EXPECT_NEAR(int(pixel & 255u), 64, 2);         // red under two panes
    EXPECT_NEAR(int(pixel >> 8 & 255u), 64, 2);    // green under one
    EXPECT_NEAR(int(pixel >> 16 & 255u), 128, 2);  // blue on top

    // As ids, half of the nearest pane's pixels are there, and the red one stops what is left.
    VisibilityBuffer buffer;
    ASSERT_TRUE(renderer->render_ids(make_view({}, 64, 64), {.instances = all_instances(scene)}, buffer, stats));
    int nearest = 0;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            const float depth = buffer.depth[buffer.index(x, y)];
            EXPECT_LT(depth, 5.001f);
            nearest += depth < 3.5f;
        }
    }
    EXPECT_NEAR(nearest, 64 * 64 / 2, 64 * 64 / 20);
}

TEST_F(NearRendererTest, the_shaded_picture_is_the_same_every_time) {
    const scene::SceneData world = test::make_forest({.trees = 100, .size_m = 80.0});
    const scene::StaticScene scene = world.view();
    auto renderer = NearRenderer::make(scene);
    ASSERT_TRUE(renderer) << renderer.error().message;
    shading::Image first, second;
    NearStats stats;
    const auto ids = all_instances(scene);
    ASSERT_TRUE(renderer->render_shaded(street_view(), {.instances = ids}, first, stats));
    ASSERT_TRUE(renderer->render_shaded(street_view(), {.instances = ids}, second, stats));
    EXPECT_EQ(first.pixels, second.pixels);
}

}  // namespace
}  // namespace ff::nearfield
