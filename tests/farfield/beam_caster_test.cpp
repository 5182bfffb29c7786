// Tile beams against a brute force in double: every triangle of every instance, for every pixel.

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <hwy/highway.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/alpha_test.h"
#include "engine/farfield/ray_caster.h"
#include "tests/support/tiles.h"
#include "tests/support/wind.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

using scene::SceneData;
using scene::StaticScene;

struct OracleHit {
    std::uint32_t instance = kSkyInstance, triangle = 0;
    double depth = std::numeric_limits<double>::infinity();
    bool near_edge = false;  // some triangle's edge passes so near that rounding decides
};

// How far a point is inside a triangle: the least barycentric; below 0 outside.
struct OracleTriangle {
    std::uint32_t instance, triangle;
    DVec3 a, ab, ac;  // relative to the eye
    bool see_through;
    AlphaSurface surface;
};

std::vector<OracleTriangle> oracle_triangles(const StaticScene& scene, const WorldPos& eye) {
    std::vector<OracleTriangle> out;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const scene::Instance& instance = scene.instances[i];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
            const std::size_t triangle = mesh.first_triangle + t;
            DVec3 p[3];
            for (std::size_t k = 0; k < 3; ++k) {
                p[k] = DMat3(instance.world_from_mesh) *
                           DVec3(scene.positions[mesh.first_vertex + scene.indices[3 * triangle + k]]) +
                       (instance.position - eye);
            }
            const AlphaSurface surface = make_alpha_surface(scene, instance, i, t);
            out.push_back({i, t, p[0], p[1] - p[0], p[2] - p[0], surface.is_see_through, surface});
        }
    }
    return out;
}

// The least angle between a ray and the planes through the eye and an edge, radians. What barycentrics do not tell of a
// triangle that is seen nearly edge-on: there a rounding is a good part of its height in the image.
double edge_angle(const OracleTriangle& t, const DVec3& direction) {
    const DVec3 corners[3] = {t.a, t.a + t.ab, t.a + t.ac};
    double least = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const DVec3 across = glm::cross(corners[k], corners[(k + 1) % 3]);
        const double length = glm::length(across) * glm::length(direction);
        if (length > 0.0) least = std::min(least, std::abs(glm::dot(across, direction)) / length);
    }
    return least;
}
constexpr double kEdgeAngle = 1e-6;  // some roundings of a float

OracleHit oracle_hit(const std::vector<OracleTriangle>& triangles, const DVec3& direction, double pixel_angle,
                     const LeafSway& sway) {
    OracleHit hit;
    double second = hit.depth;
    for (const OracleTriangle& t : triangles) {
        const DVec3 n = glm::cross(t.ab, t.ac);
        const double det = -glm::dot(n, direction);
        const double size = glm::length(n) * glm::length(direction);
        if (size == 0.0) continue;
        const double depth = -glm::dot(n, t.a) / det;
        const DVec3 q = depth * direction - t.a;
        const double nn = glm::dot(n, n);
        const double b1 = glm::dot(glm::cross(q, t.ac), n) / nn, b2 = glm::dot(glm::cross(t.ab, q), n) / nn;
        const double least = std::min({b1, b2, 1.0 - b1 - b2});
        // A pixel is doubtful where it comes nearer to an edge than float vertices are exact.
        const double longest = std::max(glm::length(t.ab), glm::length(t.ac));
        const double height = glm::length(n) / longest;
        const double reach = glm::length(t.a) + longest;
        const double tolerance = 1e-5 * reach / height;
        if (std::abs(det) < 1e-5 * size || !std::isfinite(depth)) {
            // Edge-on. Doubtful if the ray passes near it at all.
            const DVec3 m = t.a + (t.ab + t.ac) / 3.0;
            const double along = glm::dot(m, direction) / glm::dot(direction, direction);
            if (glm::length(m - std::max(along, 0.0) * direction) <= longest * 1.01) hit.near_edge = true;
            continue;
        }
        if (depth < -1e-3 * reach) continue;
        if (std::abs(least) < tolerance) hit.near_edge = true;
        if (std::abs(least) < 1e-3 && edge_angle(t, direction) < kEdgeAngle) hit.near_edge = true;
        if (least < 0.0 || depth <= 0.0) continue;
        if (depth < 1e-3) hit.near_edge = true;
        if (t.see_through) {
            const float footprint = float(depth * pixel_angle);
            const SwayPlace place{&sway, Vec3(depth * direction)};
            const bool opaque = is_opaque_at(t.surface, float(b1), float(b2), footprint, false, place);
            for (const double d1 : {-1e-4, 1e-4}) {
                for (const double d2 : {-1e-4, 1e-4}) {
                    for (const float scale : {0.999f, 1.001f}) {
                        if (is_opaque_at(t.surface, float(b1 + d1), float(b2 + d2), footprint * scale, false, place) !=
                            opaque)
                            hit.near_edge = true;
                    }
                }
            }
            if (!opaque) continue;
        }
        if (depth < hit.depth) {
            second = hit.depth;
            hit.depth = depth;
            hit.instance = t.instance;
            hit.triangle = t.triangle;
        } else {
            second = std::min(second, depth);
        }
    }
    if (second - hit.depth < 1e-4 * hit.depth) hit.near_edge = true;  // a tie but for rounding
    return hit;
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

struct Differences {
    int pixels = 0, doubtful = 0, wrong = 0, hits = 0;
    double worst_depth_error = 0.0;
};

// Compares one view with the oracle.
void compare(const SceneData& data, const Camera& camera, int width, int height, Differences& sum,
             const std::string& what, const LeafSway& sway = {}) {
    const StaticScene scene = data.view();
    const auto caster = make_beam_caster(scene);
    PinholeView view = make_view(camera, width, height);
    view.sway = sway;
    const VisibilityBuffer out = cast_all(*caster, view);
    const std::vector<OracleTriangle> triangles = oracle_triangles(scene, view.position);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const DVec3 direction = DMat3(view.world_from_camera) * DVec3((x + 0.5) * view.u_step + view.u_first,
                                                                          (y + 0.5) * view.v_step + view.v_first, -1.0);
            const OracleHit hit = oracle_hit(triangles, direction, view.pixel_angle(), sway);
            const std::size_t at = out.index(x, y);
            ++sum.pixels;
            ASSERT_FALSE(std::isnan(out.depth[at])) << what;
            if (hit.near_edge) {
                ++sum.doubtful;
                continue;
            }
            const bool same =
                out.instance[at] == hit.instance && (hit.instance == kSkyInstance || out.triangle[at] == hit.triangle);
            if (!same) {
                if (++sum.wrong < 5) {
                    ADD_FAILURE() << what << " pixel " << x << ", " << y << ": found " << out.instance[at] << "/"
                                  << out.triangle[at] << " at " << out.depth[at] << ", expected " << hit.instance << "/"
                                  << hit.triangle << " at " << hit.depth;
                }
            } else if (hit.instance != kSkyInstance) {
                ++sum.hits;
                sum.worst_depth_error = std::max(sum.worst_depth_error, std::abs(out.depth[at] / hit.depth - 1.0));
            }
        }
    }
}

void expect_few_doubts(const Differences& sum) {
    EXPECT_EQ(sum.wrong, 0) << "of " << sum.pixels << ", " << sum.doubtful << " doubtful";
    EXPECT_LT(sum.doubtful, sum.pixels / 8);
    EXPECT_GT(sum.hits, sum.pixels / 50);
    testing::Test::RecordProperty("doubtful", sum.doubtful);
    testing::Test::RecordProperty("worst_depth_error_1e9", int(1e9 * sum.worst_depth_error));
}

DBox3 cube(const WorldPos& middle, double half) {
    return {middle - DVec3(half), middle + DVec3(half)};
}

TEST(BeamCaster, FindsWhatABruteForceFindsInsideATriangleSoup) {
    Differences sum;
    for (std::uint32_t seed = 0; seed < 160; ++seed) {
        const SceneData data = test::make_triangle_soup({.triangles = 60}, {.seed = seed, .height_grid_size = 16});
        test::Random random(seed);
        compare(data, test::random_camera(random, cube(WorldPos(0.0), 8.0)), 48, 40, sum, fmt::format("seed {}", seed));
    }
    expect_few_doubts(sum);
}

TEST(BeamCaster, FindsWhatABruteForceFindsInMaskedTriangles) {
    Differences sum;
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        const SceneData data =
            test::make_triangle_soup({.triangles = 60, .masked = true}, {.seed = seed, .height_grid_size = 16});
        test::Random random(seed);
        compare(data, test::random_camera(random, cube(WorldPos(0.0), 12.0)), 48, 40, sum,
                fmt::format("seed {}", seed));
    }
    expect_few_doubts(sum);
}

TEST(BeamCaster, FindsWhatABruteForceFindsWhereTrianglesCrossTheEyePlane) {
    Differences sum;
    for (std::uint32_t seed = 0; seed < 160; ++seed) {
        const SceneData data = test::make_triangle_soup({.triangles = 6, .size_m = 10.0, .edge_m = 100.0},
                                                        {.seed = seed, .height_grid_size = 16});
        test::Random random(seed);
        compare(data, test::random_camera(random, cube(WorldPos(0.0), 5.0)), 40, 40, sum, fmt::format("seed {}", seed));
    }
    expect_few_doubts(sum);
}

TEST(BeamCaster, FindsWhatABruteForceFindsInAForestFarFromTheOrigin) {
    Differences sum;
    const WorldPos origin(3.0e6, 100.0, -7.0e6);
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        const SceneData data = test::make_forest({.trees = 12, .size_m = 24.0, .masked = seed % 2 == 0, .leaves = 60},
                                                 {.seed = seed, .origin = origin, .height_grid_size = 16});
        Camera camera;
        camera.position = origin + DVec3(0.0, 2.0, 14.0);
        compare(data, camera, 64, 48, sum, fmt::format("seed {}", seed));
    }
    expect_few_doubts(sum);
}

TEST(BeamCaster, FindsWhatABruteForceFindsInLeavesThatWindMoves) {
    Differences sum;
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        SceneData data =
            test::make_forest({.trees = 12, .size_m = 24.0, .leaves = 60}, {.seed = seed, .height_grid_size = 16});
        test::let_leaves_sway(data);
        const Camera camera{.position = {0.0, 2.0, 14.0}, .yaw = 0.4 * seed, .roll = 0.3};
        compare(data, camera, 64, 48, sum, fmt::format("seed {}", seed), test::storm(float(seed), 40.0f));
    }
    expect_few_doubts(sum);
}

TEST(BeamCaster, LeavesMoveWithTimeAndOnlyWithinTheWindsReach) {
    SceneData data = test::make_forest({.trees = 60, .size_m = 80.0, .leaves = 60});
    test::let_leaves_sway(data);
    const StaticScene scene = data.view();
    const auto caster = make_beam_caster(scene);
    PinholeView view = make_view({.position = {0.0, 2.0, 44.0}}, 160, 120);
    const VisibilityBuffer still = cast_all(*caster, view);
    constexpr float kWithin = 40.0f;
    view.sway = test::storm(1.0f, kWithin);
    const VisibilityBuffer moved = cast_all(*caster, view);
    view.sway = test::storm(1.4f, kWithin);
    const VisibilityBuffer later = cast_all(*caster, view);
    int by_wind = 0, by_time = 0;
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const std::size_t at = still.index(x, y);
            const auto differs = [&](const VisibilityBuffer& a, const VisibilityBuffer& b) {
                return a.instance[at] != b.instance[at] || a.triangle[at] != b.triangle[at];
            };
            by_time += differs(moved, later);
            if (!differs(still, moved)) continue;
            ++by_wind;
            // What has changed is the nearer one of what is seen: a leaf that came or one that went.
            const float nearer = std::min(still.depth[at], moved.depth[at]) * glm::length(view.direction(x, y));
            EXPECT_LT(nearer, kWithin) << x << ", " << y;
        }
    EXPECT_GT(by_wind, 100);
    EXPECT_GT(by_time, 100);
}

TEST(BeamCaster, GivesTheSameBitsForOneAndTwoWorkers) {
    const SceneData data = test::make_forest({.trees = 60, .size_m = 60.0});
    const StaticScene scene = data.view();
    const auto caster = make_beam_caster(scene);
    Camera camera;
    camera.position = {0.0, 2.0, 20.0};
    const PinholeView view = make_view(camera, 200, 120);
    VisibilityBuffer images[2];
    CastCost costs[2];
    for (int i = 0; i < 2; ++i) {
        const WorkerLimit limit(i + 1);
        images[i].resize(view.width, view.height);
        costs[i] = caster->cast_tiles(view, all_tiles(view), images[i]);
    }
    EXPECT_EQ(images[0].instance, images[1].instance);
    EXPECT_EQ(images[0].triangle, images[1].triangle);
    EXPECT_EQ(images[0].depth, images[1].depth);
    EXPECT_EQ(costs[0].nodes, costs[1].nodes);
    EXPECT_EQ(costs[0].triangles, costs[1].triangles);
    EXPECT_EQ(costs[0].rays, 200u * 120u);
}

TEST(BeamCaster, AnswersOnlyThePixelsAskedForAndEachAsInAWholeImage) {
    const SceneData data = test::make_triangle_soup({.triangles = 100, .masked = true});
    const StaticScene scene = data.view();
    const auto caster = make_beam_caster(scene);
    test::Random random(5);
    for (int round = 0; round < 20; ++round) {
        // The image ends within a tile, and requests reach beyond it.
        const PinholeView view = make_view(test::random_camera(random, cube(WorldPos(0.0), 12.0)), 70, 50);
        const VisibilityBuffer whole = cast_all(*caster, view);
        std::vector<TileRequest> tiles = all_tiles(view);
        for (TileRequest& tile : tiles) {
            for (std::uint16_t& row : tile.rows) row = std::uint16_t(random.below(65536) & random.below(65536));
        }
        VisibilityBuffer some;
        some.resize(view.width, view.height);
        for (std::uint32_t& t : some.triangle) t = 12345;
        caster->cast_tiles(view, tiles, some);
        for (const TileRequest& tile : tiles) {
            for (int j = 0; j < kTileSize; ++j) {
                for (int i = 0; i < kTileSize; ++i) {
                    const std::size_t at = some.index(tile.x + i, tile.y + j);
                    const bool asked = (tile.rows[j] >> i) & 1 && tile.x + i < view.width && tile.y + j < view.height;
                    if (!asked) {
                        ASSERT_EQ(some.instance[at], kUnresolved);
                        ASSERT_EQ(some.triangle[at], 12345u);
                        continue;
                    }
                    ASSERT_EQ(some.instance[at], whole.instance[at]);
                    ASSERT_EQ(some.triangle[at], whole.triangle[at]);
                    ASSERT_EQ(some.depth[at], whole.depth[at]);
                }
            }
        }
    }
}

TEST(BeamCaster, NeverSeesThroughAClosedSurface) {
    int sky = 0, pixels = 0;
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        test::Random random(seed);
        const double radius = std::pow(10.0, random.in(-1.0, 4.0));
        const int rings = 4 + int(random.below(60));
        const SceneData data = test::make_closed_sphere(radius, rings, 0.2, {.height_grid_size = 16});
        const StaticScene scene = data.view();
        const auto caster = make_beam_caster(scene);
        const Camera camera = test::random_camera(random, cube(WorldPos(0.0), 0.4 * radius));
        const VisibilityBuffer out = cast_all(*caster, make_view(camera, 320, 240));
        for (int y = 0; y < 240; ++y) {
            for (int x = 0; x < 320; ++x) sky += out.instance[out.index(x, y)] == kSkyInstance;
        }
        pixels += 320 * 240;
    }
    EXPECT_EQ(sky, 0) << "of " << pixels;
}

TEST(BeamCaster, HasNoCrackWhereEdgesAndVerticesFallOnPixelCentres) {
    // Fans around a vertex that stands exactly on a pixel centre, with spokes along rows, columns and diagonals.
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        test::Random random(seed);
        Camera camera;
        const PinholeView view = make_view(camera, 64, 64);
        const float depth = float(random.in(0.5, 50.0));
        const auto at_pixel = [&](double x, double y, float d) {
            return Vec3(float((x + 0.5) * view.u_step + view.u_first), float((y + 0.5) * view.v_step + view.v_first),
                        -1.0f) *
                   d;
        };
        scene::MeshSource mesh;
        const double cx = 8.0 + random.below(48), cy = 8.0 + random.below(48);
        const int spokes = 4 + int(random.below(14));
        std::vector<Vec3> rim;
        for (int i = 0; i < spokes; ++i) {
            const double angle = 2.0 * kPi * (seed % 2 == 0 ? i : i + 0.7 * random.unit()) / spokes;
            rim.push_back(at_pixel(cx + 6.0 * std::cos(angle), cy + 6.0 * std::sin(angle), depth));
        }
        for (int i = 0; i < spokes; ++i) {
            test::append_triangle(mesh, at_pixel(cx, cy, depth), rim[std::size_t(i)],
                                  rim[std::size_t((i + 1) % spokes)], 0);
        }
        SceneData data;
        data.materials.push_back(test::plain_material());
        const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
        data.add_instance(id, WorldPos(0.0), Mat3(1.0f), 0);
        data.finish(16);
        const StaticScene scene = data.view();
        const VisibilityBuffer out = cast_all(*make_beam_caster(scene), view);
        for (int y = -1; y <= 1; ++y) {
            for (int x = -1; x <= 1; ++x)
                ASSERT_EQ(out.instance[out.index(int(cx) + x, int(cy) + y)], 0u) << "seed " << seed;
        }
    }
}

TEST(BeamCaster, TellsOnWhichSideOfTheEdgesOfTinyTrianglesAPixelLies) {
    // Triangles of a tenth of a pixel whose left edge passes a pixel's centre at 1/5000 of one, anywhere in a square.
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        test::Random random(seed);
        const PinholeView view = make_view(Camera{}, 64, 64);
        const float depth = float(random.in(0.5, 5000.0));
        const auto at_pixel = [&](double x, double y) {
            return Vec3(float((x + 0.5) * view.u_step + view.u_first), float((y + 0.5) * view.v_step + view.v_first),
                        -1.0f) *
                   depth;
        };
        const int x = int(random.below(64)), y = int(random.below(64));
        for (const double gap_px : {-2e-4, 2e-4}) {
            const double left = x + gap_px;
            const SceneData data = test::make_single_triangle(at_pixel(left, y - 0.05), at_pixel(left, y + 0.05),
                                                              at_pixel(left + 0.1, y), {.height_grid_size = 16});
            const StaticScene scene = data.view();
            const VisibilityBuffer out = cast_all(*make_beam_caster(scene), view);
            ASSERT_EQ(out.instance[out.index(x, y)], gap_px < 0.0 ? 0u : kSkyInstance)
                << "seed " << seed << ", pixel " << x << ", " << y << ", gap " << gap_px;
        }
    }
}

TEST(BeamCaster, ShowsTheSmallerIdWhereTrianglesCoincide) {
    scene::MeshSource mesh;
    for (int i = 0; i < 40; ++i) test::append_triangle(mesh, Vec3(-9, -9, -5), Vec3(9, -9, -5), Vec3(0, 9, -5), 0);
    SceneData data;
    data.materials.push_back(test::plain_material());
    const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
    for (int i = 0; i < 5; ++i) data.add_instance(id, WorldPos(0.0), Mat3(1.0f), 0);
    data.finish(16);
    const StaticScene scene = data.view();
    const VisibilityBuffer out = cast_all(*make_beam_caster(scene), make_view(Camera{}, 32, 32));
    EXPECT_EQ(out.instance[out.index(16, 16)], 0u);
    EXPECT_EQ(out.triangle[out.index(16, 16)], 0u);
}

TEST(BeamCaster, SeesTheSameWithEveryInstructionSet) {
    const SceneData forest = test::make_forest({.trees = 60, .size_m = 60.0});
    const SceneData sphere = test::make_closed_sphere(10.0, 20, 0.2);
    Camera camera;
    camera.position = {0.0, 2.0, 20.0};
    const PinholeView view = make_view(camera, 160, 120);
    const StaticScene forest_scene = forest.view(), sphere_scene = sphere.view();
    const VisibilityBuffer best = cast_all(*make_beam_caster(forest_scene), view);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().DeInit();
        const VisibilityBuffer out = cast_all(*make_beam_caster(forest_scene), view);
        int different = 0;
        for (std::size_t i = 0; i < out.depth.size(); ++i)
            different += out.instance[i] != best.instance[i] || out.triangle[i] != best.triangle[i];
        EXPECT_LT(different, 20) << hwy::TargetName(target);  // edges fall on one or the other side
        const VisibilityBuffer inside = cast_all(*make_beam_caster(sphere_scene), make_view(Camera{}, 160, 112));
        for (const std::uint32_t instance : inside.instance) ASSERT_EQ(instance, 0u) << hwy::TargetName(target);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
}

TEST(BeamCaster, SeesOnlySkyInAnEmptyWorld) {
    const SceneData data = test::make_empty_world();
    const StaticScene scene = data.view();
    const auto caster = make_beam_caster(scene);
    const VisibilityBuffer out = cast_all(*caster, make_view(Camera{}, 40, 24));
    EXPECT_EQ(out.instance[out.index(3, 3)], kSkyInstance);
    EXPECT_EQ(out.depth[out.index(3, 3)], std::numeric_limits<float>::infinity());
    EXPECT_EQ(out.instance[out.index(40, 3)], kUnresolved);  // beyond the image, in the padding
}

TEST(BeamCaster, SingleRaysFindWhatTilesFind) {
    int compared = 0, different = 0;
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        const SceneData data = test::make_triangle_soup({.triangles = 80}, {.seed = seed, .height_grid_size = 16});
        const StaticScene scene = data.view();
        const auto caster = make_beam_caster(scene);
        test::Random random(seed);
        const PinholeView view = make_view(test::random_camera(random, cube(WorldPos(0.0), 12.0)), 64, 48);
        const VisibilityBuffer out = cast_all(*caster, view);
        std::vector<Ray> rays;
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) rays.push_back({view.position, view.direction(x, y)});
        }
        std::vector<RayHit> hits(rays.size());
        caster->cast_rays(rays, hits);
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                const RayHit& hit = hits[std::size_t(y * view.width + x)];
                const std::size_t at = out.index(x, y);
                ++compared;
                if (hit.instance != out.instance[at] || hit.triangle != out.triangle[at])
                    different += hit.instance == kSkyInstance || std::abs(hit.t / out.depth[at] - 1.0f) > 1e-4f;
            }
        }
    }
    EXPECT_LT(different, compared / 5000) << "of " << compared;
}

TEST(BeamCaster, RaysThatAreNoRaysAreSky) {
    const SceneData data = test::make_closed_sphere(10.0, 8);
    const StaticScene scene = data.view();
    const auto caster = make_beam_caster(scene);
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const std::vector<Ray> rays = {
        {WorldPos(0.0), Vec3(nan, 0, 1)},    {WorldPos(0.0, double(nan), 0.0), Vec3(0, 0, 1)},
        {WorldPos(0.0), Vec3(0.0f)},         {WorldPos(0.0), Vec3(inf, 0, 0)},
        {WorldPos(0.0), Vec3(0, 0, 1e-20f)}, {WorldPos(0.0), Vec3(-0.0f, 0.0f, 1.0f)}};
    std::vector<RayHit> hits(rays.size());
    caster->cast_rays(rays, hits);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(hits[i].instance, kSkyInstance) << i;
        EXPECT_EQ(hits[i].t, inf) << i;
    }
    EXPECT_EQ(hits[4].instance, 0u);
    EXPECT_EQ(hits[5].instance, 0u);
    EXPECT_NEAR(hits[5].t, 10.0f, 1.0f);
}

TEST(BeamCaster, SingleRaysNeverLeaveAClosedSurface) {
    const SceneData data = test::make_closed_sphere(10.0, 12, 0.1);
    const StaticScene scene = data.view();
    const auto caster = make_beam_caster(scene);
    std::vector<Ray> rays;
    test::Random random(3);
    for (const Vec3& vertex : scene.positions) {  // straight at vertices and at the middles of edges
        rays.push_back({WorldPos(0.0), vertex});
        rays.push_back({WorldPos(0.0), vertex + scene.positions[random.below(std::uint32_t(scene.positions.size()))]});
    }
    for (int i = 0; i < 20000; ++i) rays.push_back({WorldPos(0.0), random.in_box(Vec3(-1.0f), Vec3(1.0f))});
    std::vector<RayHit> hits(rays.size());
    caster->cast_rays(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (glm::length(rays[i].direction) > 1e-3f) {
            ASSERT_EQ(hits[i].instance, 0u) << i;
        }
    }
}

}  // namespace
}  // namespace ff::farfield
