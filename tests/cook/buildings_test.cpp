#include "tools/cook/buildings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tools/cook/buildings_facade.h"
#include "tools/cook/scatter.h"

namespace ff::cook {
namespace {

namespace fs = std::filesystem;

double triangulated_area(const Ring& outer, const std::vector<Ring>& holes) {
    std::vector<DVec2> points = outer;
    for (const Ring& hole : holes) points.insert(points.end(), hole.begin(), hole.end());
    const std::vector<std::uint32_t> ids = triangulate(outer, holes);
    double area = 0;
    for (std::size_t i = 0; i < ids.size(); i += 3) {
        const DVec2 corners[3] = {points[ids[i]], points[ids[i + 1]], points[ids[i + 2]]};
        const double a = signed_area(corners);
        EXPECT_GT(a, 0.0);
        area += a;
    }
    return area;
}

Ring star(std::uint64_t seed, DVec2 center, double low, double high, int corners) {
    Ring ring;
    for (int i = 0; i < corners; ++i) {
        const double a = 2 * kPi * i / corners, r = low + (high - low) * hash_unit(seed, std::uint64_t(i));
        ring.push_back(center + DVec2(r * std::cos(a), r * std::sin(a)));
    }
    return ring;
}

TEST(Triangulate, covers_random_stars_with_holes_exactly) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const Ring outer = star(seed, {3, -2}, 20, 60, 5 + int(seed % 60));
        std::vector<Ring> holes;
        double expected = signed_area(outer);
        for (std::uint64_t h = 0; h < seed % 5; ++h) {
            const double a = 2 * kPi * double(h) / 4;
            Ring hole = star(seed * 7 + h, DVec2(3 + 9 * std::cos(a), -2 + 9 * std::sin(a)), 1.5, 4, 3 + int(h) * 4);
            normalize_ring(hole, false);
            expected += signed_area(hole);
            holes.push_back(hole);
        }
        if (expected < 0 || outer.size() < 12) holes.clear(), expected = signed_area(outer);
        ASSERT_NEAR(triangulated_area(outer, holes), expected, 1e-6 * expected) << "seed " << seed;
    }
}

TEST(Triangulate, survives_rings_that_are_none) {
    EXPECT_TRUE(triangulate({}, {}).empty());
    EXPECT_TRUE(triangulate({{0, 0}, {1, 1}}, {}).empty());
    (void)triangulate({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, {});                                           // crosses itself
    (void)triangulate({{0, 0}, {0, 0}, {0, 0}, {0, 0}}, {});                                           // a point
    (void)triangulate({{0, 0}, {5, 0}, {5, 5}, {0, 5}}, std::vector<Ring>{{{9, 9}, {9, 8}, {8, 8}}});  // a hole outside
}

TEST(Footprint, rings_lose_repeated_and_collinear_points) {
    Ring ring{{0, 0}, {0, 5}, {0, 10}, {0, 10}, {10, 10}, {10, 0}, {5, 0}};
    normalize_ring(ring, true);
    EXPECT_EQ(ring.size(), 4u);
    EXPECT_NEAR(signed_area(ring), 100, 1e-9);
    Ring line{{0, 0}, {5, 0}, {10, 0}};
    normalize_ring(line, true);
    EXPECT_TRUE(line.empty());
}

class RealFootprints : public testing::TestWithParam<std::tuple<const char*, std::size_t>> {};

TEST_P(RealFootprints, are_read_and_stand) {
    const auto& [name, least] = GetParam();
    const fs::path path = fs::path(FF_SHARED_DIR) / "content/city" / name;
    if (!fs::exists(path)) GTEST_SKIP() << "no shared content at " << FF_SHARED_DIR;
    CookCache cache;
    CookContext context(cache);
    std::optional<GroundFrame> frame;
    const Result<std::vector<Footprint>> footprints = read_footprints(path, {}, OutlineKind::buildings, frame, context);
    ASSERT_TRUE(footprints) << footprints.error().message;
    EXPECT_GE(footprints->size(), least);
    for (const Footprint& footprint : *footprints) {
        double expected = signed_area(footprint.outer);
        for (const Ring& hole : footprint.holes) expected += signed_area(hole);
        ASSERT_NEAR(triangulated_area(footprint.outer, footprint.holes), expected, 0.01 * expected + 0.01)
            << footprint.name;
    }
    WorldSource world;
    world.materials.resize(1);
    add_buildings(
        *footprints, {}, [](double, double) { return 0.0; }, world);
    EXPECT_GT(world.meshes.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Cities, RealFootprints,
                         testing::Values(std::tuple("baltimore_buildings.geojson", std::size_t(1700)),
                                         std::tuple("moscow_buildings.geojson", std::size_t(640)),
                                         std::tuple("liechtenstein.osm.pbf", std::size_t(1000))));

TEST(Scatter, keeps_out_of_buildings_and_off_steep_ground) {
    WorldSource world;
    world.meshes.resize(1);
    Model tree{.name = "tree", .parts = {ModelPart{}}, .bounds = {}, .triangle_count = 1};
    Obstacles obstacles;
    Footprint house;
    house.outer = {{-20, -20}, {20, -20}, {20, 20}, {-20, 20}};
    obstacles.add(house);
    obstacles.finish();
    ScatterRule rule{.density_per_km2 = 40000, .area = {-200, -200, 200, 200}};
    rule.slope_max_deg = 30;
    rule.weights = {1.0};
    const GroundHeight ground = [](double x, double) -> std::optional<double> { return x > 100 ? 2 * (x - 100) : 0.0; };
    scatter(std::span(&tree, 1), rule, ground, obstacles, world);
    EXPECT_NEAR(double(world.placements.size()), 40000 * 0.16 * 0.75 - 40000 * 0.0018, 300);
    for (const Placement& placement : world.placements) {
        EXPECT_LE(placement.position.x, 100.5);
        EXPECT_TRUE(std::abs(placement.position.x) > 21.4 || std::abs(placement.position.z) > 21.4);
        EXPECT_EQ(placement.kind, PlacementKind::instance);
    }
}

}  // namespace
}  // namespace ff::cook
