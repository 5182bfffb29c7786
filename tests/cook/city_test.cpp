#include "tools/cook/city.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <random>
#include <string>

#include "engine/core/jobs.h"
#include "tools/cook/city_cars.h"
#include "tools/cook/city_plan.h"

namespace ff::test {
namespace {

using namespace cook;  // NOLINT: a test of one of its parts
using city::CityPlan;
using city::CityProp;
using city::CitySettings;
using city::CitySite;

double sloping_ground(double x, double z) {
    return 12.0 + 0.004 * x - 0.003 * z;
}

struct City {
    WorldSource world;
    CitySite site;
    std::size_t triangles = 0;
    explicit City(const CitySettings& settings) {
        city::add_city(settings, {}, sloping_ground, world, site);
        for (const SourceMesh& mesh : world.meshes) triangles += mesh.geometry.triangle_materials.size();
    }
};

CitySettings small_city(double scale = 1) {
    CitySettings settings;
    settings.seed = 5;
    settings.size_m = 500, settings.downtown_m = 140, settings.scale = scale;
    return settings;
}

bool same_bytes(const SourceMesh& a, const SourceMesh& b) {
    const auto same = [](const auto& v, const auto& w) {
        return v.size() == w.size() && std::memcmp(v.data(), w.data(), v.size() * sizeof(v[0])) == 0;
    };
    return a.name == b.name && same(a.geometry.positions, b.geometry.positions) &&
           same(a.geometry.attributes, b.geometry.attributes) && same(a.geometry.indices, b.geometry.indices) &&
           same(a.geometry.triangle_materials, b.geometry.triangle_materials);
}

/// First hit of a ray: whether it sees the triangle's outer side.
struct Triangles {
    std::vector<std::array<DVec3, 3>> all;

    explicit Triangles(const WorldSource& world) {
        for (const Placement& placement : world.placements) {
            const scene::MeshSource& mesh = world.meshes[placement.mesh].geometry;
            for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
                std::array<DVec3, 3> corners;
                for (std::size_t c = 0; c < 3; ++c)
                    corners[c] = placement.position + DVec3(mesh.positions[mesh.indices[t + c]]);
                all.push_back(corners);
            }
        }
    }
    [[nodiscard]] std::optional<bool> sees_outside(const DVec3& origin, const DVec3& direction) const {
        double nearest = 1e300;
        std::optional<bool> outside;
        for (const auto& [a, b, c] : all) {
            const DVec3 e1 = b - a, e2 = c - a, p = glm::cross(direction, e2);
            const double det = glm::dot(e1, p);
            if (std::abs(det) < 1e-12) continue;
            const double u = glm::dot(origin - a, p) / det;
            if (u < 0 || u > 1) continue;
            const DVec3 q = glm::cross(origin - a, e1);
            const double v = glm::dot(direction, q) / det;
            if (v < 0 || u + v > 1) continue;
            const double t = glm::dot(e2, q) / det;
            if (t > 1e-6 && t < nearest) nearest = t, outside = det > 0;
        }
        return outside;
    }
};

DVec2 kerb_middle(const CityPlan& plan, city::BlockIndex index) {
    return city::point_in(plan.kerb(index), 0.5, 0.5);
}

TEST(City, stores_about_two_million_triangles_and_grows_with_its_scale) {
    const City one(CitySettings{});
    EXPECT_GT(one.triangles, 1'700'000u);
    EXPECT_LT(one.triangles, 2'100'000u);
    CitySettings settings;
    settings.scale = 4;
    const City four(settings);
    EXPECT_NEAR(double(four.triangles) / double(one.triangles), 4.0, 0.3);
    EXPECT_LT(one.world.materials.size(), 40u);
}

TEST(City, has_more_triangles_the_more_detail_is_asked_for) {
    CitySettings plain = small_city(), rich = small_city();
    plain.detail = 0.5, rich.detail = 2.0;
    EXPECT_LT(City(plain).triangles, City(small_city()).triangles);
    EXPECT_LT(City(small_city()).triangles, City(rich).triangles);
}

TEST(City, is_the_same_for_one_worker_and_for_two) {
    const auto build = [](int workers) {
        const WorkerLimit limit(workers);
        return City(small_city());
    };
    const City one = build(1), two = build(2);
    ASSERT_EQ(one.world.meshes.size(), two.world.meshes.size());
    for (std::size_t i = 0; i < one.world.meshes.size(); ++i)
        EXPECT_TRUE(same_bytes(one.world.meshes[i], two.world.meshes[i])) << one.world.meshes[i].name;
    EXPECT_EQ(one.site.props.size(), two.site.props.size());
}

TEST(City, keeps_its_inner_blocks_when_it_grows) {
    const City small(small_city()), large(small_city(4));
    ASSERT_LT(small.world.meshes.size(), large.world.meshes.size());
    for (std::size_t i = 0; i < small.world.meshes.size(); ++i) {
        EXPECT_TRUE(same_bytes(small.world.meshes[i], large.world.meshes[i])) << small.world.meshes[i].name;
        EXPECT_EQ(small.world.placements[i].position, large.world.placements[i].position);
    }
}

TEST(City, has_finite_vertices_within_its_radius_and_normals_that_agree_with_its_faces) {
    CitySettings settings = small_city(3);
    settings.center_x = 4000, settings.center_z = -7000;
    const City city(settings);
    const double radius = city::city_flat_radius_m(settings);
    std::size_t wrong = 0;
    for (const Placement& placement : city.world.placements) {
        const scene::MeshSource& mesh = city.world.meshes[placement.mesh].geometry;
        ASSERT_EQ(mesh.positions.size(), mesh.attributes.size());
        for (const Vec3& p : mesh.positions) {
            ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
            const DVec3 world = placement.position + DVec3(p);
            ASSERT_LT(std::hypot(world.x - settings.center_x, world.z - settings.center_z), radius);
        }
        for (const scene::VertexAttributes& a : mesh.attributes)
            ASSERT_TRUE(std::isfinite(a.uv.x) && std::isfinite(a.uv.y));
        for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
            const Vec3 &a = mesh.positions[mesh.indices[t]], &b = mesh.positions[mesh.indices[t + 1]],
                       &c = mesh.positions[mesh.indices[t + 2]];
            const Vec3 face = glm::cross(b - a, c - a);
            if (glm::length(face) < 1e-6f) continue;
            const Vec3 normal = scene::decode_normal(mesh.attributes[mesh.indices[t]].normal_oct);
            wrong += glm::dot(glm::normalize(face), normal) < 0.9f;
        }
    }
    EXPECT_EQ(wrong, 0u);
}

TEST(City, shows_outer_sides_only_to_those_who_walk_its_streets) {
    const CitySettings settings = small_city();
    const City city(settings);
    const Triangles triangles(city.world);
    const CityPlan plan(settings);
    std::mt19937 random(3);
    const auto uniform = [&] { return double(random()) / 4294967296.0; };
    int hits = 0, inner = 0;
    for (int i = 0; i < 300; ++i) {
        // In the middle of a crossing, at eye height.
        const city::BlockIndex west{int(random() % 3) - 1, int(random() % 3) - 1};
        const DVec2 p = 0.5 * (plan.kerb(west)[2] + plan.kerb({west.column + 1, west.row + 1})[0]);
        const double azimuth = 2 * M_PI * uniform(), up = -0.15 + 0.9 * uniform();
        const DVec3 direction = glm::normalize(DVec3(std::cos(azimuth), up, std::sin(azimuth)));
        const DVec3 eye(p.x, sloping_ground(p.x, -p.y) + 1.7, -p.y);
        const std::optional<bool> outside = triangles.sees_outside(eye, direction);
        hits += outside.has_value();
        inner += outside.has_value() && !*outside;
    }
    EXPECT_GT(hits, 150);
    // The bars of balconies have one side only.
    EXPECT_LE(inner, 2);
}

TEST(City, keeps_buildings_off_the_streets_and_props_out_of_buildings) {
    const CitySettings settings = small_city(2);
    const City city(settings);
    const CityPlan plan(settings);
    std::vector<city::Quad> kerbs;
    for (const city::BlockIndex index : plan.blocks_within(settings.size_m)) kerbs.push_back(plan.kerb(index));
    ASSERT_GT(city.site.buildings.size(), 100u);
    for (const std::array<DVec2, 4>& building : city.site.buildings)
        for (const DVec2& corner : building)
            EXPECT_TRUE(std::any_of(kerbs.begin(), kerbs.end(),
                                    [&](const city::Quad& kerb) {
                                        return contains(city::inset_quad(kerb, 1.0), DVec2(corner.x, -corner.y));
                                    }))
                << corner.x << " " << corner.y;
    ASSERT_GT(city.site.props.size(), 200u);
    for (const CityProp& prop : city.site.props)
        for (const std::array<DVec2, 4>& building : city.site.buildings) {
            const city::Quad plan_quad{DVec2(building[0].x, -building[0].y), DVec2(building[1].x, -building[1].y),
                                       DVec2(building[2].x, -building[2].y), DVec2(building[3].x, -building[3].y)};
            EXPECT_FALSE(contains(plan_quad, DVec2(prop.position.x, -prop.position.z)))
                << prop.position.x << " " << prop.position.z;
        }
}

TEST(CityCar, stands_on_wheels_that_are_as_wide_from_ahead_as_tyres_are) {
    const CitySettings settings;
    const CityPlan plan(settings);
    city::CityMaterials materials;
    materials.plain = 1;
    const city::GroundHeight ground = [](double, double) { return 0.0; };
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        city::BlockWriter writer{
            .plan = plan, .materials = materials, .ground = ground, .block = {}, .mesh = {"car", {}}};
        city::add_car(writer, DVec2(0.0), DVec2(0.0, 1.0), 0.0, seed);  // ahead is -z
        const scene::MeshSource mesh = writer.mesh.take().geometry;
        // What of plain black shows to who stands before the car or behind it, projected: the lower halves of four
        // tyres at least 15 cm wide. Flat discs show as streaks through a spyglass, or not at all.
        double before = 0.0, behind = 0.0, lowest = 1.0;
        for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
            if (mesh.triangle_materials[t] != materials.plain) continue;
            std::array<DVec3, 3> p;
            for (std::size_t c = 0; c < 3; ++c) {
                p[c] = DVec3(mesh.positions[mesh.indices[3 * t + c]]);
                lowest = std::min(lowest, p[c].y);
            }
            const double facing = 0.5 * glm::cross(p[1] - p[0], p[2] - p[0]).z;
            before += std::max(-facing, 0.0);
            behind += std::max(facing, 0.0);
        }
        EXPECT_GT(before, 4 * 0.15 * 0.32) << seed;
        EXPECT_GT(behind, 4 * 0.15 * 0.32) << seed;
        EXPECT_NEAR(lowest, 0.0, 1e-6) << seed << ": they stand on the road";
    }
}

TEST(CityPlan, has_blocks_of_60_to_120_metres_and_streets_of_12_to_26) {
    const CityPlan plan(CitySettings{});
    for (const city::BlockIndex index : plan.blocks_within(3000)) {
        const city::Quad kerb = plan.kerb(index);
        for (std::size_t i = 0; i < 4; ++i) {
            const double side = glm::length(kerb[(i + 1) % 4] - kerb[i]);
            EXPECT_GT(side, 60.0);
            EXPECT_LT(side, 120.0);
        }
        EXPECT_GE(plan.street_width(index.column, true), 12.0);
        EXPECT_LE(plan.street_width(index.column, true), 26.0);
    }
    EXPECT_LT(glm::length(kerb_middle(plan, {0, 0})), 30.0);
}

}  // namespace
}  // namespace ff::test
