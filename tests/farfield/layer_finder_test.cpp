// Transparent layers against a brute force in double, and casters that look past them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/farfield/layer_reference.h"
#include "engine/farfield/ray_caster.h"
#include "tests/support/tiles.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

using scene::SceneData;
using scene::StaticScene;

/// Makes a world's masked materials blended ones.
void blend_masked(SceneData& data, float alpha) {
    for (scene::Material& material : data.materials) {
        if ((material.flags & scene::kMaterialAlphaMask) == 0) continue;
        material.flags = scene::kMaterialBlend | scene::kMaterialDoubleSided;
        material.base_color.a = alpha;
    }
    for (scene::Mesh& mesh : data.meshes)
        if ((mesh.material_flags & scene::kMaterialAlphaMask) != 0)
            mesh.material_flags = (mesh.material_flags & ~scene::kMaterialAlphaMask) | scene::kMaterialBlend;
}

std::vector<TileRequest> all_tiles(const PinholeView& view) {
    return test::all_tiles(view.width, view.height);
}

VisibilityBuffer cast_all(RayCaster& caster, const PinholeView& view) {
    VisibilityBuffer out;
    out.resize(view.width, view.height);
    caster.cast_tiles(view, all_tiles(view), out);
    return out;
}

struct Sum {
    int pixels = 0, layers = 0, expected = 0, wrong = 0, unsure = 0;
};

/// The layers of a view, found and by brute force.
void compare(const LayerScene& layers, const PinholeView& view, const VisibilityBuffer& visible, Sum& sum) {
    const beam::BeamView beam_view(view);
    std::vector<Layer> room(kMaxTileLayers);
    for (const TileRequest& tile : all_tiles(view)) {
        const std::size_t count = find_layers(layers, beam_view, tile, visible, room);
        ASSERT_LE(count, room.size());
        for (int y = tile.y; y < std::min(tile.y + kTileSize, view.height); ++y)
            for (int x = tile.x; x < std::min(tile.x + kTileSize, view.width); ++x) {
                const auto pixel = std::uint32_t((y - tile.y) * kTileSize + x - tile.x);
                const double seen = visible.depth[visible.index(x, y)];
                const auto reference = reference_layers(layers, view, x, y, seen * 1.001, 1.0);
                // Where opaque ones certainly begin, and where they may.
                double certain_end = 1e30, possible_end = 1e30;
                for (const ReferenceLayer& r : reference) {
                    if (r.alpha > 1.0 - 0.9 * kAlphaStep && r.inside >= 0.0)
                        certain_end = std::min(certain_end, r.depth);
                    if (r.alpha > 1.0 - 1.1 * kAlphaStep) possible_end = std::min(possible_end, r.depth);
                }
                const auto tolerance = [](const ReferenceLayer& r) {
                    return 1e-5 * (r.depth + 2.0 * r.edge_m) / r.height_m;
                };
                ++sum.pixels;
                for (std::size_t i = 0; i < count; ++i) {
                    const Layer& found = room[i];
                    if (found.pixel != pixel) continue;
                    ++sum.layers;
                    const auto match = std::find_if(reference.begin(), reference.end(), [&](const ReferenceLayer& r) {
                        return r.instance == found.instance && r.triangle == found.triangle;
                    });
                    const bool is_there = match != reference.end() && match->inside >= -tolerance(*match);
                    if (!is_there) {  // a sliver's plane is nobody's guess
                        ++sum.unsure;
                        continue;
                    }
                    const double place = tolerance(*match);
                    const bool same_mip = std::abs(match->lod - std::floor(match->lod) - 0.5) > 1e-3;
                    const bool is_flat = match->height_m > 1e-3 * match->edge_m;
                    if (is_flat && std::abs(found.depth / match->depth - 1.0) > 1e-4 + place && ++sum.wrong < 5)
                        ADD_FAILURE() << x << ", " << y << ": depth " << found.depth << " of " << match->depth;
                    if (is_flat && same_mip && std::abs(double(found.alpha) - match->alpha) > 0.01 + 64.0 * place &&
                        ++sum.wrong < 5)
                        ADD_FAILURE() << x << ", " << y << ": alpha " << found.alpha << " of " << match->alpha
                                      << ", lod " << match->lod;
                }
                for (const ReferenceLayer& r : reference) {
                    const double least_alpha = 0.02 + 64.0 * tolerance(r);
                    if (r.inside < tolerance(r) || r.alpha < least_alpha || r.depth < 1e-3) continue;
                    if (r.depth > 0.999 * std::min({seen, possible_end, certain_end})) continue;
                    if (r.depth * double(glm::length(view.direction(x, y))) > 0.9999 * view.blend_within_m) continue;
                    ++sum.expected;
                    const bool is_found =
                        std::any_of(room.begin(), room.begin() + std::ptrdiff_t(count), [&](const Layer& l) {
                            return l.pixel == pixel && l.instance == r.instance && l.triangle == r.triangle;
                        });
                    if (!is_found && ++sum.wrong < 5)
                        ADD_FAILURE() << x << ", " << y << ": not found " << r.instance << "/" << r.triangle << " at "
                                      << r.depth << ", alpha " << r.alpha << ", seen " << seen;
                }
            }
    }
}

void expect_right(const Sum& sum) {
    EXPECT_EQ(sum.wrong, 0) << "of " << sum.layers;
    EXPECT_GT(sum.expected, sum.pixels / 20);
    EXPECT_LT(sum.unsure, sum.layers / 100 + 5);
}

/// Layers before what the tile caster sees of the same world.
void compare_world(const SceneData& data, const Camera& camera, float within_m, Sum& sum) {
    const StaticScene scene = data.view();
    const LayerIndex index = make_layer_index(scene);
    PinholeView view = make_view(camera, 40, 36);
    view.blend_within_m = within_m;
    const VisibilityBuffer visible = cast_all(*make_beam_caster(scene), view);
    compare({scene, index}, view, visible, sum);
}

DBox3 cube(const WorldPos& middle, double half) {
    return {middle - DVec3(half), middle + DVec3(half)};
}

TEST(LayerFinder, finds_what_a_brute_force_finds_in_a_triangle_soup) {
    Sum sum;
    for (std::uint32_t seed = 0; seed < 24; ++seed) {
        SceneData data =
            test::make_triangle_soup({.triangles = 60, .masked = true}, {.seed = seed, .height_grid_size = 16});
        blend_masked(data, seed % 2 == 0 ? 0.7f : 1.0f);
        test::Random random(seed);
        compare_world(data, test::random_camera(random, cube(WorldPos(0.0), 10.0)), seed % 3 == 0 ? 6.0f : 100.0f, sum);
    }
    expect_right(sum);
}

TEST(LayerFinder, finds_triangles_that_cross_the_eye_plane) {
    Sum sum;
    for (std::uint32_t seed = 0; seed < 24; ++seed) {
        SceneData data = test::make_triangle_soup({.triangles = 8, .size_m = 10.0, .edge_m = 100.0, .masked = true},
                                                  {.seed = seed, .height_grid_size = 16});
        for (scene::Material& material : data.materials) material.base_color_texture = scene::kNoTexture;
        blend_masked(data, 0.5f);
        test::Random random(seed);
        compare_world(data, test::random_camera(random, cube(WorldPos(0.0), 5.0)), 60.0f, sum);
    }
    expect_right(sum);
}

TEST(LayerFinder, finds_leaves_of_instances_far_from_the_origin) {
    Sum sum;
    const WorldPos origin(3.0e6, 100.0, -7.0e6);
    SceneData data =
        test::make_forest({.trees = 12, .size_m = 24.0, .leaves = 60}, {.origin = origin, .height_grid_size = 16});
    blend_masked(data, 0.9f);
    Camera camera;
    camera.position = origin + DVec3(0.0, 2.0, 14.0);
    compare_world(data, camera, 12.0f, sum);
    expect_right(sum);
}

TEST(LayerFinder, finds_moving_instances) {
    SceneData data = test::make_forest({.trees = 6, .size_m = 24.0, .leaves = 60}, {.height_grid_size = 16});
    blend_masked(data, 0.9f);
    const StaticScene scene = data.view();
    // The same trees once more, moved.
    std::vector<scene::Instance> moving(data.instances.begin(), data.instances.end());
    std::erase_if(moving, [&](const scene::Instance& i) { return data.meshes[i.mesh].material_flags == 0; });
    for (scene::Instance& instance : moving) {
        instance.position.x += 1.5;
        instance.bounds.low.x += 1.5, instance.bounds.high.x += 1.5;
    }
    std::vector<scene::BvhNode> nodes;
    build_instance_bvh(moving, scene.origin, nodes);
    StaticScene dynamic = scene;
    dynamic.instances = moving;
    dynamic.instance_nodes = nodes;
    const LayerIndex index = make_layer_index(scene);
    PinholeView view = make_view({.position = {0.0, 2.0, 14.0}}, 40, 36);
    view.blend_within_m = 30.0f;
    Sum sum;
    compare({scene, index, &dynamic}, view, cast_all(*make_beam_caster(scene), view), sum);
    expect_right(sum);
}

TEST(LayerFinder, a_shared_edge_gives_every_pixel_one_layer) {
    SceneData data;
    data.materials.push_back(test::plain_material());
    data.materials[0].flags = scene::kMaterialBlend | scene::kMaterialDoubleSided;
    data.materials[0].base_color.a = 0.5f;
    scene::MeshSource mesh;
    for (int i = -4; i < 4; ++i)
        for (int j = -4; j < 4; ++j) {
            const Vec3 a(float(i), float(j), 0.0f);
            test::append_quad(mesh, a, a + Vec3(1, 0, 0), a + Vec3(1, 1, 0), a + Vec3(0, 1, 0), 0);
        }
    data.add_instance(data.add_mesh(prepare_mesh(std::move(mesh), data.materials)), WorldPos(0.0), Mat3(1.0f), 0);
    data.finish(16);
    const StaticScene scene = data.view();
    const LayerIndex index = make_layer_index(scene);
    test::Random random(7);
    for (int round = 0; round < 50; ++round) {
        // Pixel centres on the very edges in the first: one unit to 8 pixels.
        Camera camera{.position = {0.0, 0.0, 4.0}, .vertical_fov = 2.0 * std::atan(1.0)};
        if (round > 0)
            camera = {.position = random.in_box(DVec3(-1, -1, 2), DVec3(1, 1, 3)),
                      .yaw = random.in(-0.3, 0.3),
                      .roll = random.in(-3.0, 3.0),
                      .vertical_fov = 0.7};
        PinholeView view = make_view(camera, 64, 64);
        if (round == 0) view.u_first += 0.5f * view.u_step, view.v_first += 0.5f * view.v_step;
        view.blend_within_m = 100.0f;
        VisibilityBuffer nothing;
        nothing.resize(view.width, view.height);
        std::vector<Layer> room(kMaxTileLayers);
        for (const TileRequest& tile : all_tiles(view)) {
            const std::size_t count = find_layers({scene, index}, beam::BeamView(view), tile, nothing, room);
            int layers_of[kTileSize * kTileSize]{};
            for (std::size_t i = 0; i < count; ++i) ++layers_of[room[i].pixel];
            const bool at_border = round == 0 && (tile.x == 0 || tile.y == 0 || tile.x == 48 || tile.y == 48);
            for (int pixel = 0; pixel < kTileSize * kTileSize && !at_border; ++pixel)
                ASSERT_EQ(layers_of[pixel], 1)
                    << "round " << round << " tile " << tile.x << ", " << tile.y << " pixel " << pixel;
        }
    }
}

TEST(LayerFinder, says_how_much_room_it_lacks) {
    SceneData data =
        test::make_triangle_soup({.triangles = 200, .edge_m = 12.0, .masked = true}, {.height_grid_size = 16});
    for (scene::Material& material : data.materials) material.base_color_texture = scene::kNoTexture;
    blend_masked(data, 0.2f);
    const StaticScene scene = data.view();
    const LayerIndex index = make_layer_index(scene);
    PinholeView view = make_view({.position = {0.0, 0.0, 12.0}}, 16, 16);
    view.blend_within_m = 100.0f;
    VisibilityBuffer nothing;
    nothing.resize(16, 16);
    std::vector<Layer> room(kMaxTileLayers), little(10);
    const TileRequest tile = all_tiles(view).front();
    const std::size_t count = find_layers({scene, index}, beam::BeamView(view), tile, nothing, room);
    ASSERT_GT(count, little.size());
    EXPECT_EQ(find_layers({scene, index}, beam::BeamView(view), tile, nothing, little), count);
}

TEST(LayerFinder, a_scene_without_blended_materials_has_an_empty_index) {
    const SceneData data = test::make_forest({.trees = 6, .size_m = 24.0, .leaves = 60}, {.height_grid_size = 16});
    const StaticScene scene = data.view();
    const LayerIndex index = make_layer_index(scene);
    EXPECT_TRUE(index.is_empty());
    EXPECT_EQ(index.memory_bytes(), 0u);
    EXPECT_FALSE(has_layers_within(scene, index, WorldPos(0.0), 1e6));
}

TEST(LayerFinder, knows_how_near_the_next_layer_may_be) {
    SceneData data = test::make_forest({.trees = 40, .size_m = 24.0, .leaves = 60}, {.height_grid_size = 16});
    blend_masked(data, 1.0f);
    const StaticScene scene = data.view();
    const LayerIndex index = make_layer_index(scene);
    EXPECT_TRUE(has_layers_within(scene, index, WorldPos(0.0, 2.0, 0.0), 10.0));
    EXPECT_FALSE(has_layers_within(scene, index, WorldPos(0.0, 2.0, 100.0), 60.0));
    EXPECT_TRUE(has_layers_within(scene, index, WorldPos(0.0, 2.0, 100.0), 100.0));
}

/// All casters look past layers but for what is solid of them, wherever the border runs.
TEST(CastersAndLayers, all_casters_see_the_same) {
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        SceneData data =
            test::make_forest({.trees = 40, .size_m = 40.0, .leaves = 60}, {.seed = seed, .height_grid_size = 16});
        blend_masked(data, seed % 2 == 0 ? 1.0f : 0.6f);
        const StaticScene scene = data.view();
        PinholeView view = make_view({.position = {0.0, 2.0, 20.0}, .roll = 0.1 * seed}, 160, 120);
        view.blend_within_m = 20.0f;
        const VisibilityBuffer beam = cast_all(*make_beam_caster(scene), view);
        int solid = 0, beyond = 0;
        for (const bool embree : {true, false}) {
            const auto caster = embree ? make_embree_caster(scene) : make_grid_caster(scene);
            const VisibilityBuffer other = cast_all(*caster, view);
            int different = 0;
            for (int y = 0; y < view.height; ++y)
                for (int x = 0; x < view.width; ++x) {
                    const std::size_t at = beam.index(x, y);
                    different += beam.instance[at] != other.instance[at] || beam.triangle[at] != other.triangle[at];
                }
            EXPECT_LT(different, view.width * view.height / 200) << "seed " << seed;
        }
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const std::size_t at = beam.index(x, y);
                if (beam.instance[at] == kSkyInstance) continue;
                const scene::Mesh& mesh = scene.meshes[scene.instances[beam.instance[at]].mesh];
                if (scene.triangle_materials[mesh.first_triangle + beam.triangle[at]] == 0) continue;
                const bool near = beam.depth[at] * glm::length(view.direction(x, y)) < view.blend_within_m;
                (near ? solid : beyond) += 1;
            }
        EXPECT_GT(beyond, 100);
        if (seed % 2 == 0)
            EXPECT_GT(solid, 100);
        else
            EXPECT_EQ(solid, 0);
    }
}

}  // namespace
}  // namespace ff::farfield
