// The grid and Embree against a brute force in double: every triangle of every instance, for every ray.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/alpha_test.h"
#include "engine/farfield/embree_caster.h"
#include "engine/farfield/ray_caster.h"
#include "tests/support/wind.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

using scene::SceneData;
using scene::StaticScene;

constexpr double kInf = std::numeric_limits<double>::infinity();

struct Oracle {
    std::uint32_t instance = kSkyInstance, triangle = 0;
    double t = kInf;
    double second = kInf;   // next hit behind the first
    bool is_close = false;  // an edge passes so near that rounding decides
};

Oracle brute_force(const StaticScene& scene, const WorldPos& origin, const DVec3& d, double pixel_angle,
                   const LeafSway& sway = {}) {
    Oracle hit;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const scene::Instance& instance = scene.instances[i];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
            DVec3 p[3];
            for (std::size_t k = 0; k < 3; ++k)
                p[k] =
                    DMat3(instance.world_from_mesh) *
                        DVec3(scene.positions[mesh.first_vertex + scene.indices[3 * (mesh.first_triangle + t) + k]]) +
                    (instance.position - origin);
            const double a = glm::dot(d, glm::cross(p[2], p[1])), b = glm::dot(d, glm::cross(p[0], p[2]));
            const double c = glm::dot(d, glm::cross(p[1], p[0])), volume = a + b + c;
            const DVec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const double along = glm::dot(d, normal);
            const double distance = glm::dot(p[0], normal) / along;
            const double size = glm::length(p[0]) * glm::length(p[1]) * glm::length(p[2]) * glm::length(d);
            const double margin = std::min({a / volume, b / volume, c / volume});
            const bool is_edge_on = std::fabs(volume) < 1e-7 * size || !std::isfinite(distance);
            const bool in_reach = distance > -1e-3 && distance < hit.t + 1e-3;
            // Nothing of no area can be seen; of a triangle seen edge-on only rounding decides.
            if (glm::length(normal) < 1e-9) continue;
            if (is_edge_on) {
                const bool is_near = std::fabs(a) < 1e-6 * size && std::fabs(b) < 1e-6 * size &&
                                     std::fabs(c) < 1e-6 * size && glm::dot(d, p[0] + p[1] + p[2]) > 0;
                if (is_near) hit.is_close = true;
                continue;
            }
            if (std::fabs(margin) < 1e-4 && in_reach) hit.is_close = true;
            if (margin < 0 || !(distance >= 0)) continue;
            const AlphaSurface surface = make_alpha_surface(scene, instance, i, t);
            if (surface.is_see_through) {
                // The texel's border decides where it passes near.
                const float b1 = float(b / volume), b2 = float(c / volume), foot = float(pixel_angle * distance);
                const SwayPlace place{&sway, Vec3(distance * d)};
                int opaque = 0;
                for (const float du : {-2e-4f, 0.0f, 2e-4f})
                    for (const float dv : {-2e-4f, 0.0f, 2e-4f})
                        for (const float df : {0.999f, 1.001f})
                            opaque += is_opaque_at(surface, b1 + du, b2 + dv, foot * df, false, place);
                if (opaque != 0 && opaque != 18) hit.is_close = true;
                if (!is_opaque_at(surface, b1, b2, foot, false, place)) continue;
            }
            if (distance < hit.t) {
                hit.second = hit.t;
                hit.instance = i, hit.triangle = t, hit.t = distance;
            } else {
                hit.second = std::min(hit.second, distance);
            }
        }
    }
    if (hit.t < kInf && hit.second - hit.t < 1e-4 * (1 + hit.t)) hit.is_close = true;
    if (hit.t < 1e-3) hit.is_close = true;
    return hit;
}

struct NamedCaster {
    std::string name;
    std::function<std::unique_ptr<RayCaster>(const StaticScene&)> make;
};

class Casters : public testing::TestWithParam<NamedCaster> {};

INSTANTIATE_TEST_SUITE_P(
    All, Casters,
    testing::Values(
        NamedCaster{"Grid", [](const StaticScene& s) { return make_grid_caster(s); }},
        NamedCaster{"Embree8", [](const StaticScene& s) { return make_embree_caster(s, {.packet_width = 8}); }},
        NamedCaster{"Embree16", [](const StaticScene& s) { return make_embree_caster(s, {.packet_width = 16}); }}),
    [](const auto& test) { return test.param.name; });

std::vector<TileRequest> all_tiles(int width, int height) {
    std::vector<TileRequest> tiles;
    for (int y = 0; y < height; y += kTileSize)
        for (int x = 0; x < width; x += kTileSize) {
            TileRequest tile{std::uint16_t(x), std::uint16_t(y), {}};
            std::fill(std::begin(tile.rows), std::end(tile.rows), std::uint16_t(0xFFFF));
            tiles.push_back(tile);
        }
    return tiles;
}

void expect_agreement(RayCaster& caster, const StaticScene& scene, const PinholeView& view, std::uint32_t seed) {
    VisibilityBuffer out;
    out.resize(view.width, view.height);
    const CastCost cost = caster.cast_tiles(view, all_tiles(view.width, view.height), out);
    EXPECT_EQ(cost.rays, std::uint64_t(view.width * view.height));
    int compared = 0;
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const Oracle hit =
                brute_force(scene, view.position, DVec3(view.direction(x, y)), view.pixel_angle(), view.sway);
            if (hit.is_close) continue;
            ++compared;
            const std::size_t at = out.index(x, y);
            ASSERT_EQ(out.instance[at], hit.instance)
                << "seed " << seed << " pixel " << x << ", " << y << ": depth " << out.depth[at] << " for " << hit.t;
            if (hit.instance == kSkyInstance) continue;
            ASSERT_EQ(out.triangle[at], hit.triangle) << "seed " << seed << " pixel " << x << ", " << y;
            ASSERT_NEAR(out.depth[at], hit.t, 1e-3 * (1 + hit.t)) << "seed " << seed << " pixel " << x << ", " << y;
        }
    EXPECT_GT(compared, view.width * view.height / 4) << "seed " << seed;
}

TEST_P(Casters, FindWhatABruteForceFindsInTriangleSoups) {
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        test::Random random(seed);
        const SceneData world = test::make_triangle_soup({}, {.seed = seed});
        const StaticScene scene = world.view();
        const auto caster = GetParam().make(scene);
        expect_agreement(*caster, scene, make_view(test::random_camera(random, scene.bounds), 41, 29), seed);
    }
}

TEST_P(Casters, FindWhatABruteForceFindsInMaskedTriangles) {
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        test::Random random(seed);
        const SceneData world = test::make_triangle_soup({.masked = true}, {.seed = seed});
        const StaticScene scene = world.view();
        const auto caster = GetParam().make(scene);
        expect_agreement(*caster, scene, make_view(test::random_camera(random, scene.bounds), 41, 29), seed);
    }
}

TEST_P(Casters, FindWhatABruteForceFindsInLeavesThatWindMoves) {
    for (std::uint32_t seed = 0; seed < 3; ++seed) {
        test::Random random(seed);
        SceneData world = test::make_forest({.trees = 12, .size_m = 30, .leaves = 40}, {.seed = seed});
        test::let_leaves_sway(world);
        const StaticScene scene = world.view();
        const auto caster = GetParam().make(scene);
        PinholeView view = make_view(test::random_camera(random, scene.bounds), 41, 29);
        view.sway = test::storm(float(seed), 40.0f);
        expect_agreement(*caster, scene, view, seed);
    }
}

TEST_P(Casters, FindWhatABruteForceFindsAmongTurnedScaledAndMirroredTreesFarFromTheOrigin) {
    for (std::uint32_t seed = 0; seed < 3; ++seed) {
        test::Random random(seed);
        const SceneData world =
            test::make_forest({.trees = 12, .size_m = 30, .leaves = 12}, {.seed = seed, .origin = {1e6, 0, -1e6}});
        const StaticScene scene = world.view();
        const auto caster = GetParam().make(scene);
        expect_agreement(*caster, scene, make_view(test::random_camera(random, scene.bounds), 41, 29), seed);
    }
}

TEST_P(Casters, FindWhatABruteForceFindsFromWithinACity) {
    test::Random random(3);
    const SceneData world = test::make_city({.cells = 2, .subdivisions = 2});
    const StaticScene scene = world.view();
    const auto caster = GetParam().make(scene);
    for (std::uint32_t seed = 0; seed < 4; ++seed)
        expect_agreement(*caster, scene, make_view(test::random_camera(random, scene.bounds), 33, 25), seed);
}

TEST_P(Casters, AnswerSingleRaysAsABruteForceDoes) {
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        test::Random random(seed + 100);
        const SceneData world = test::make_triangle_soup({}, {.seed = seed});
        const StaticScene scene = world.view();
        const auto caster = GetParam().make(scene);
        std::vector<Ray> rays(400);
        for (Ray& ray : rays) {
            ray.origin = scene.origin + DVec3(random.in_box(Vec3(-25), Vec3(25)));
            ray.direction = random.in_box(Vec3(-1), Vec3(1));
            if (random.below(4) == 0) ray.direction[int(random.below(3))] = 0.0f;
        }
        std::vector<RayHit> hits(rays.size());
        caster->cast_rays(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Oracle hit = brute_force(scene, rays[i].origin, DVec3(rays[i].direction), 0.0);
            if (hit.is_close) continue;
            ASSERT_EQ(hits[i].instance, hit.instance) << "seed " << seed << " ray " << i;
            if (hit.instance == kSkyInstance) continue;
            ASSERT_EQ(hits[i].triangle, hit.triangle) << "seed " << seed << " ray " << i;
            ASSERT_NEAR(hits[i].t, hit.t, 1e-3 * (1 + hit.t)) << "seed " << seed << " ray " << i;
        }
    }
}

TEST_P(Casters, FollowAxisParallelRaysThatStartOnCellAndTriangleBorders) {
    // A floor of unit quads: rays straight down on grid lines, vertices and between them.
    scene::MeshSource mesh;
    for (int z = -8; z < 8; ++z)
        for (int x = -8; x < 8; ++x)
            test::append_quad(mesh, Vec3(x, 0, z), Vec3(x + 1, 0, z), Vec3(x + 1, 0, z + 1), Vec3(x, 0, z + 1), 0);
    SceneData world;
    world.materials.push_back(test::plain_material());
    world.add_instance(world.add_mesh(scene::prepare_mesh(std::move(mesh), world.materials)), DVec3(0.0), Mat3(1.0f),
                       0);
    world.finish(16);
    const StaticScene scene = world.view();
    const auto caster = GetParam().make(scene);
    std::vector<Ray> rays;
    for (int j = -15; j < 16; ++j)
        for (int i = -15; i < 16; ++i) {
            rays.push_back({DVec3(0.5 * i, 4, 0.5 * j), Vec3(0, -1, 0)});
            rays.push_back({DVec3(0.5 * i, -2, 0.5 * j), Vec3(0, 1, 0)});
        }
    std::vector<RayHit> hits(rays.size());
    caster->cast_rays(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(hits[i].instance, 0u) << "ray " << i << " from " << rays[i].origin.x << ", " << rays[i].origin.z;
        ASSERT_NEAR(hits[i].t, std::fabs(rays[i].origin.y), 1e-4);
    }
}

TEST_P(Casters, CallRaysWithoutADirectionSky) {
    const SceneData world = test::make_closed_sphere(10, 12);
    const StaticScene scene = world.view();
    const auto caster = GetParam().make(scene);
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const std::vector<Ray> rays = {{DVec3(0.0), Vec3(nan, 0, 1)},
                                   {DVec3(0.0), Vec3(0, inf, 1)},
                                   {DVec3(0.0, double(nan), 0.0), Vec3(0, 0, 1)},
                                   {DVec3(0.0), Vec3(0.0f)}};
    std::vector<RayHit> hits(rays.size(), RayHit{1, 1, 1.0f});
    caster->cast_rays(rays, hits);
    for (const RayHit& hit : hits) {
        EXPECT_EQ(hit.instance, kSkyInstance);
        EXPECT_EQ(hit.t, inf);
    }
    PinholeView view = make_view(Camera{}, 16, 16);
    view.position.x = double(nan);
    VisibilityBuffer out;
    out.resize(16, 16);
    caster->cast_tiles(view, all_tiles(16, 16), out);
    for (const std::uint32_t instance : out.instance) EXPECT_EQ(instance, kSkyInstance);
}

TEST_P(Casters, NeverSeeThroughAClosedSurface) {
    for (std::uint32_t seed = 0; seed < 3; ++seed) {
        test::Random random(seed);
        const SceneData world = test::make_closed_sphere(50, 40, 0.1, {.seed = seed});
        const StaticScene scene = world.view();
        const auto caster = GetParam().make(scene);
        Camera camera = test::random_camera(random, DBox3{DVec3(-20.0), DVec3(20.0)});
        const PinholeView view = make_view(camera, 320, 240);
        VisibilityBuffer out;
        out.resize(view.width, view.height);
        caster->cast_tiles(view, all_tiles(320, 240), out);
        int leaks = 0;
        for (const std::uint32_t instance : out.instance) leaks += instance != 0u;
        EXPECT_EQ(leaks, 0) << "seed " << seed;
    }
}

TEST_P(Casters, AnswerOnlyThePixelsAskedForAndEachAsInAWholeImage) {
    const SceneData world = test::make_city({.cells = 2});
    const StaticScene scene = world.view();
    const auto caster = GetParam().make(scene);
    test::Random random(5);
    const PinholeView view = make_view(test::random_camera(random, scene.bounds), 100, 75);
    VisibilityBuffer whole, part;
    whole.resize(view.width, view.height);
    caster->cast_tiles(view, all_tiles(view.width, view.height), whole);
    for (const std::uint32_t rarity : {2u, 3u, 9u, 60u}) {
        part.resize(view.width, view.height);
        auto tiles = all_tiles(view.width, view.height);
        std::vector<bool> asked(part.instance.size(), false);
        std::uint64_t count = 0;
        for (TileRequest& tile : tiles)
            for (int j = 0; j < kTileSize; ++j) {
                tile.rows[j] = 0;
                for (int i = 0; i < kTileSize; ++i) {
                    if (random.below(rarity) != 0) continue;
                    tile.rows[j] = std::uint16_t(tile.rows[j] | 1u << i);
                    const int x = tile.x + i, y = tile.y + j;
                    if (x >= view.width || y >= view.height) continue;
                    asked[part.index(x, y)] = true;
                    ++count;
                }
            }
        EXPECT_EQ(caster->cast_tiles(view, tiles, part).rays, count);
        int different = 0;
        for (std::size_t at = 0; at < asked.size(); ++at) {
            if (!asked[at]) {
                ASSERT_EQ(part.instance[at], kUnresolved);
                continue;
            }
            different += part.instance[at] != whole.instance[at] || part.triangle[at] != whole.triangle[at];
        }
        // Where two triangles tie, a packet's other rays may decide the order.
        EXPECT_LE(different, int(count / 500)) << "one in " << rarity;
    }
}

TEST_P(Casters, GiveTheSameBitsForOneAndTwoWorkers) {
    const SceneData world = test::make_forest({.trees = 60, .leaves = 60});
    const StaticScene scene = world.view();
    const auto caster = GetParam().make(scene);
    Camera camera;
    camera.position = {3, 2, 5};
    const PinholeView view = make_view(camera, 160, 120);
    VisibilityBuffer one, two;
    one.resize(view.width, view.height);
    two.resize(view.width, view.height);
    {
        const WorkerLimit limit(1);
        caster->cast_tiles(view, all_tiles(160, 120), one);
    }
    const WorkerLimit limit(2);
    caster->cast_tiles(view, all_tiles(160, 120), two);
    EXPECT_EQ(one.instance, two.instance);
    EXPECT_EQ(one.triangle, two.triangle);
    EXPECT_EQ(one.depth, two.depth);
}

TEST_P(Casters, SeeOnlySkyInAnEmptyWorld) {
    const SceneData world = test::make_empty_world();
    const StaticScene scene = world.view();
    const auto caster = GetParam().make(scene);
    VisibilityBuffer out;
    out.resize(32, 32);
    caster->cast_tiles(make_view(Camera{}, 32, 32), all_tiles(32, 32), out);
    for (const std::uint32_t instance : out.instance) EXPECT_EQ(instance, kSkyInstance);
}

}  // namespace
}  // namespace ff::farfield
