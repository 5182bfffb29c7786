#include "tools/cook/coincident_surfaces.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <random>

#include "engine/core/jobs.h"
#include "tests/cook/cook_worlds.h"
#include "tools/cook/assemble.h"
#include "tools/cook/coincident_pairs.h"

namespace ff::test {
namespace {

using cook::CoincidentReport;
using cook::PlacementKind;
using cook::WorldSource;
using scene::MeshSource;

/// A rectangle of two triangles in the plane y = 0 that faces up, or down.
MeshSource rectangle(double x0, double z0, double x1, double z1, std::uint16_t material, bool up = true) {
    MeshSource mesh;
    for (const auto& [x, z] : {std::pair(x0, z0), {x0, z1}, {x1, z1}, {x1, z0}}) {
        mesh.positions.push_back(Vec3(x, 0, z));
        scene::VertexAttributes attributes{.normal_oct = {}, .uv = {float(x), float(z)}, .color = 0xFFFFFFFFu};
        scene::encode_normal(Vec3(0, up ? 1 : -1, 0), attributes.normal_oct);
        mesh.attributes.push_back(attributes);
    }
    mesh.indices = up ? std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3} : std::vector<std::uint32_t>{0, 2, 1, 0, 3, 2};
    mesh.triangle_materials = {material, material};
    return mesh;
}

std::uint32_t place(WorldSource& world, MeshSource mesh, PlacementKind kind = PlacementKind::merge) {
    world.placements.push_back({.mesh = add_mesh(world, std::move(mesh)), .kind = kind});
    return static_cast<std::uint32_t>(world.placements.size() - 1);
}

/// Nothing is an instance unless it says so.
CoincidentReport resolve(WorldSource& world) {
    std::vector<bool> whole;
    for (const cook::Placement& placement : world.placements) whole.push_back(placement.kind != PlacementKind::merge);
    return cook::resolve_coincident_surfaces(world, whole);
}

std::size_t pairs_left(const WorldSource& world) {
    std::vector<cook::PlacementSlot> slots;
    for (std::uint32_t i = 0; i < world.placements.size(); ++i) slots.push_back({.placement = i});
    return cook::find_coincident_pairs({world, slots}).pairs.size();
}

/// What a ray straight down from `from` meets first: the placement, or nothing.
struct Seen {
    std::uint32_t placement = 0;
    double distance = 0;
};
std::optional<Seen> first_hit(const WorldSource& world, const DVec3& from, const DVec3& direction) {
    std::optional<Seen> seen;
    for (std::uint32_t i = 0; i < world.placements.size(); ++i) {
        const cook::Placement& at = world.placements[i];
        const MeshSource& mesh = world.meshes[at.mesh].geometry;
        for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
            std::array<DVec3, 3> p;
            for (std::size_t c = 0; c < 3; ++c)
                p[c] = DMat3(at.world_from_mesh) * DVec3(mesh.positions[mesh.indices[3 * t + c]]) + at.position - from;
            const DVec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const double distance = glm::dot(normal, p[0]) / glm::dot(normal, direction);
            const DVec3 hit = direction * distance;
            bool inside = distance > 0;
            for (std::size_t c = 0; c < 3; ++c)
                inside = inside && glm::dot(normal, glm::cross(p[(c + 1) % 3] - p[c], hit - p[c])) >= 0;
            if (inside && (!seen || distance < seen->distance)) seen = Seen{i, distance};
        }
    }
    return seen;
}
std::uint32_t seen_from_above(const WorldSource& world, double x, double z) {
    return first_hit(world, {x, 5, z}, {0, -1, 0}).value_or(Seen{~0u, 0}).placement;
}

TEST(CoincidentSurfaces, of_two_equal_opaque_triangles_the_later_is_kept) {
    WorldSource world;
    const std::uint16_t first = add_plain_material(world), second = add_plain_material(world);
    place(world, rectangle(0, 0, 4, 4, first));
    place(world, rectangle(0, 0, 4, 4, second));
    const CoincidentReport report = resolve(world);
    EXPECT_EQ(report.dropped_triangles, 2u);
    EXPECT_EQ(report.separated_triangles, 0u);
    EXPECT_TRUE(world.meshes[0].geometry.indices.empty());
    EXPECT_EQ(world.meshes[1].geometry.triangle_materials, (std::vector<std::uint16_t>{second, second}));
    EXPECT_EQ(pairs_left(world), 0u);
}

TEST(CoincidentSurfaces, equal_corners_count_in_world_space_and_whatever_their_order) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world);
    MeshSource turned = rectangle(0, 0, 4, 4, material);
    turned.indices = {2, 0, 1, 3, 0, 2};
    for (Vec3& p : turned.positions) p -= Vec3(7, 0, 0);
    place(world, rectangle(0, 0, 4, 4, material));
    world.placements[place(world, turned)].position = DVec3(7, 0, 0);
    EXPECT_EQ(resolve(world).dropped_triangles, 2u);
}

TEST(CoincidentSurfaces, a_surface_that_overlaps_another_comes_to_lie_over_it) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world), other = add_plain_material(world);
    const std::uint32_t below = place(world, rectangle(0, 0, 10, 10, material));
    const std::uint32_t above = place(world, rectangle(3.3, 2.1, 7.7, 12, other));
    ASSERT_GT(pairs_left(world), 0u);
    const CoincidentReport report = resolve(world);
    EXPECT_EQ(report.dropped_triangles, 0u);
    EXPECT_EQ(report.separated_triangles, 2u) << "the lower one stays where it is";
    EXPECT_EQ(pairs_left(world), 0u);
    EXPECT_EQ(seen_from_above(world, 5.03, 5.01), above);
    EXPECT_EQ(seen_from_above(world, 1.03, 1.01), below);
    for (const Vec3& p : world.meshes[world.placements[above].mesh].geometry.positions) {
        EXPECT_GE(p.y, 0.0f);
        EXPECT_LE(p.y, 0.0016f);
    }
}

TEST(CoincidentSurfaces, a_surface_with_holes_comes_to_lie_over_an_opaque_one_that_is_later) {
    WorldSource world;
    const std::uint16_t wall = add_plain_material(world), poster = add_plain_material(world);
    world.materials[poster].flags = scene::kMaterialAlphaMask;
    const std::uint32_t decal = place(world, rectangle(3, 3, 5, 5, poster));
    place(world, rectangle(0, 0, 10, 10, wall));
    EXPECT_EQ(resolve(world).separated_triangles, 2u);
    EXPECT_EQ(seen_from_above(world, 4.03, 4.01), decal);
}

TEST(CoincidentSurfaces, back_to_back_each_is_seen_from_its_own_side) {
    WorldSource world;
    const std::uint16_t top = add_plain_material(world), bottom = add_plain_material(world);
    const std::uint32_t up = place(world, rectangle(0, 0, 4, 4, top));
    const std::uint32_t down = place(world, rectangle(0, 0, 4, 4, bottom, false));
    const CoincidentReport report = resolve(world);
    EXPECT_EQ(report.dropped_triangles, 0u);
    EXPECT_EQ(report.separated_triangles, 2u);
    EXPECT_EQ(seen_from_above(world, 1.03, 1.01), up);
    EXPECT_EQ(first_hit(world, {1.03, -5, 1.01}, {0, 1, 0}).value().placement, down);
}

TEST(CoincidentSurfaces, foliage_back_to_back_that_looks_the_same_is_kept_once) {
    WorldSource world;
    const std::uint16_t leaf = add_plain_material(world);
    world.materials[leaf].flags = scene::kMaterialAlphaMask;
    place(world, rectangle(0, 0, 1, 1, leaf));
    place(world, rectangle(0, 0, 1, 1, leaf, false));
    EXPECT_EQ(resolve(world).dropped_triangles, 2u);

    WorldSource painted;  // the same, but the second is of another colour
    painted.materials = world.materials;
    place(painted, rectangle(0, 0, 1, 1, leaf));
    MeshSource back = rectangle(0, 0, 1, 1, leaf, false);
    for (scene::VertexAttributes& attributes : back.attributes) attributes.color = 0xFF0000FFu;
    place(painted, back);
    const CoincidentReport report = resolve(painted);
    EXPECT_EQ(report.dropped_triangles, 0u);
    EXPECT_EQ(report.separated_triangles, 2u);
}

TEST(CoincidentSurfaces, neighbours_in_one_plane_are_left_alone) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world);
    place(world, rectangle(0, 0, 1.1, 1.3, material));
    place(world, rectangle(1.1, 0, 2.7, 1.3, material));     // shares an edge
    place(world, rectangle(1.1, 1.3, 3.9, 2.9, material));   // a part of one
    place(world, rectangle(2.7, -1.7, 9.1, 1.3, material));  // a longer one
    place(world, rectangle(20, 20, 30, 30, material));       // none
    MeshSource parallel = rectangle(0, 0, 9, 9, material);   // over all, a centimetre away
    for (Vec3& p : parallel.positions) p.y = 0.01f;
    place(world, parallel);
    const WorldSource before = world;
    const CoincidentReport report = resolve(world);
    EXPECT_EQ(report.dropped_triangles + report.separated_triangles + report.moved_placements, 0u);
    for (std::size_t m = 0; m < world.meshes.size(); ++m) {
        EXPECT_EQ(world.meshes[m].geometry.positions, before.meshes[m].geometry.positions);
        EXPECT_EQ(world.meshes[m].geometry.indices, before.meshes[m].geometry.indices);
    }
}

TEST(CoincidentSurfaces, what_hangs_on_a_moved_surface_moves_with_it) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world), other = add_plain_material(world);
    place(world, rectangle(-9, -9, 9, 9, other));
    MeshSource box = box_mesh(Vec3(1), material);  // its top in the plane
    for (Vec3& p : box.positions) p.y -= 1.0f;
    const std::uint32_t placed = place(world, box);
    EXPECT_EQ(resolve(world).separated_triangles, 2u);
    // Closed still: from every corner to every other one, each edge is met by as many triangles as before.
    const MeshSource& mesh = world.meshes[world.placements[placed].mesh].geometry;
    int at_top = 0;
    for (const std::uint32_t index : mesh.indices) {
        const float y = mesh.positions[index].y;
        EXPECT_TRUE(y == -2.0f || (y > 0.0f && y < 0.002f)) << y;
        at_top += y > 0.0f;
    }
    EXPECT_EQ(at_top, 6 + 4 * 3) << "corners of the top, and of the sides";
}

TEST(CoincidentSurfaces, an_instance_that_shares_a_plane_moves_as_a_whole) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world);
    const std::uint32_t tile = add_mesh(world, rectangle(0, 0, 2, 2, material));
    for (const double x : {0.0, 1.5, 3.0, 10.0})
        world.placements.push_back({.mesh = tile, .position = {x, 0, 0}, .kind = PlacementKind::instance});
    const CoincidentReport report = resolve(world);
    EXPECT_EQ(report.separated_triangles, 0u);
    EXPECT_EQ(report.moved_placements, 2u);
    EXPECT_EQ(world.placements[0].position.y, 0.0);
    EXPECT_GT(world.placements[1].position.y, 0.0);
    EXPECT_GT(world.placements[2].position.y, world.placements[1].position.y);
    EXPECT_EQ(world.placements[3].position.y, 0.0);
    EXPECT_EQ(pairs_left(world), 0u);
}

TEST(CoincidentSurfaces, a_mesh_with_instances_is_mended_once_for_all) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world);
    MeshSource doubled = rectangle(0, 0, 2, 2, material);
    doubled.indices.insert(doubled.indices.end(), {0, 1, 2, 0, 2, 3});
    doubled.triangle_materials.insert(doubled.triangle_materials.end(), 2, material);
    const std::uint32_t mesh = add_mesh(world, doubled);
    for (const double x : {0.0, 50.0, 100.0})
        world.placements.push_back({.mesh = mesh, .position = {x, 0, 0}, .kind = PlacementKind::instance});
    EXPECT_EQ(resolve(world).dropped_triangles, 2u);
    EXPECT_EQ(world.meshes[mesh].geometry.triangle_materials.size(), 2u);
    EXPECT_EQ(world.meshes.size(), 1u);
}

TEST(CoincidentSurfaces, a_mesh_that_is_merged_in_two_places_is_changed_in_one) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world), other = add_plain_material(world);
    place(world, rectangle(0, 0, 10, 10, other));
    const std::uint32_t tile = add_mesh(world, rectangle(0, 0, 2, 2, material));
    world.placements.push_back({.mesh = tile, .position = {3, 0, 3}});
    world.placements.push_back({.mesh = tile, .position = {300, 0, 3}});
    EXPECT_EQ(resolve(world).separated_triangles, 2u);
    EXPECT_NE(world.placements[1].mesh, world.placements[2].mesh);
    for (const Vec3& p : world.meshes[world.placements[2].mesh].geometry.positions) EXPECT_EQ(p.y, 0.0f);
    EXPECT_EQ(pairs_left(world), 0u);
}

TEST(CoincidentSurfaces, a_placement_that_repeats_an_earlier_one_goes) {
    WorldSource world;
    const std::uint32_t box = add_mesh(world, box_mesh(Vec3(1), add_plain_material(world)));
    for (const double x : {0.0, 5.0, 0.0, 5.0, 0.0})
        world.placements.push_back({.mesh = box, .position = {x, 0, 0}, .kind = PlacementKind::instance});
    world.placements.push_back({.mesh = box, .kind = PlacementKind::dynamic});
    EXPECT_EQ(cook::drop_repeated_placements(world), 3u);
    ASSERT_EQ(world.placements.size(), 3u);
    EXPECT_EQ(world.placements[1].position.x, 5.0);
    EXPECT_EQ(world.placements[2].kind, PlacementKind::dynamic);
}

TEST(CoincidentSurfaces, a_heap_of_surfaces_in_one_plane_stays_flat_and_gets_an_order) {
    WorldSource world;
    for (int i = 0; i < 40; ++i)  // a road of tiles, each over a part of the one before
        place(world, rectangle(i, 0, i + 1.5, 3, add_plain_material(world)));
    resolve(world);
    EXPECT_EQ(pairs_left(world), 0u);
    for (const cook::SourceMesh& mesh : world.meshes)
        for (const Vec3& p : mesh.geometry.positions) EXPECT_LE(p.y, 4 * 0.0016f);
}

TEST(CoincidentSurfaces, what_has_no_area_or_stands_clear_has_no_partners) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world);
    place(world, rectangle(0, 0, 10, 10, material));
    place(world, rectangle(2, 2, 2, 5, material));
    place(world, rectangle(3, 3, 3, 3, material));
    place(world, {});
    world.placements[place(world, rectangle(0, 0, 5, 5, material))].stands_clear = true;
    const CoincidentReport report = resolve(world);
    EXPECT_EQ(report.dropped_triangles + report.separated_triangles, 0u);
    WorldSource empty;
    EXPECT_TRUE(resolve(empty).complete);
}

/// Rectangles in a few random planes, in several placements turned and mirrored: whatever the case, afterwards nothing
/// is left in one plane, and from each side of a plane the topmost is what faces there.
WorldSource random_planes(std::uint32_t seed) {
    WorldSource world;
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967295.0; };
    for (int i = 0; i < 3; ++i) add_plain_material(world, Vec4(float(i)));
    world.materials[2].flags = scene::kMaterialAlphaMask;
    for (int plane = 0; plane < 3; ++plane) {
        const double yaw = uniform() * 6.3, pitch = uniform() * 6.3;
        const DMat3 turn = DMat3(std::cos(yaw), 0, std::sin(yaw), 0, 1, 0, -std::sin(yaw), 0, std::cos(yaw)) *
                           DMat3(1, 0, 0, 0, std::cos(pitch), std::sin(pitch), 0, -std::sin(pitch), std::cos(pitch));
        const DVec3 position(1000.0 * plane + uniform() * 100.0, uniform() * 50.0, uniform() * 100.0);
        for (int i = 0; i < 8; ++i) {
            const double x = uniform() * 6, z = uniform() * 6;
            const std::uint32_t id = place(world, rectangle(x, z, x + 1 + uniform() * 4, z + 1 + uniform() * 4,
                                                            static_cast<std::uint16_t>(random() % 3), random() % 2));
            world.placements[id].position = position;
            world.placements[id].world_from_mesh = Mat3(turn);
        }
    }
    return world;
}

TEST(CoincidentSurfaces, in_random_turned_planes_nothing_coincides_afterwards) {
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        WorldSource world = random_planes(seed);
        ASSERT_GT(pairs_left(world), 0u) << "seed " << seed;
        const WorldSource before = world;
        resolve(world);
        EXPECT_EQ(pairs_left(world), 0u) << "seed " << seed;
        for (std::size_t m = 0; m < before.meshes.size(); ++m) {
            const MeshSource& mesh = world.meshes[m].geometry;
            for (std::size_t i = 0; i < mesh.indices.size(); ++i)
                EXPECT_LT(glm::distance(mesh.positions[mesh.indices[i]],
                                        before.meshes[m].geometry.positions[before.meshes[m].geometry.indices[i]]),
                          8 * 0.0016f)
                    << "seed " << seed;
        }
    }
}

TEST(CoincidentSurfaces, the_result_is_the_same_for_any_number_of_workers) {
    WorldSource one = random_planes(7), two = one;
    {
        const WorkerLimit limit(1);
        resolve(one);
    }
    resolve(two);
    for (std::size_t m = 0; m < one.meshes.size(); ++m) {
        EXPECT_EQ(one.meshes[m].geometry.positions, two.meshes[m].geometry.positions);
        EXPECT_EQ(one.meshes[m].geometry.indices, two.meshes[m].geometry.indices);
    }
}

TEST(CoincidentSurfaces, the_cook_tells_them_apart_and_says_so) {
    WorldSource world;
    place(world, rectangle(0, 0, 10, 10, add_plain_material(world)));
    place(world, rectangle(0, 0, 10, 10, add_plain_material(world, Vec4(0.5f))));
    place(world, rectangle(2, 2, 5, 5, add_plain_material(world, Vec4(0.2f))));
    cook::CookCache cache;
    cook::CookContext context(cache);
    const auto assembly = cook::assemble(world, {.height_grid_size = 16}, context);
    ASSERT_TRUE(assembly) << assembly.error().message;
    EXPECT_EQ(assembly->coincident.dropped_triangles, 2u);
    EXPECT_EQ(assembly->coincident.separated_triangles, 2u);
    EXPECT_EQ(assembly->scene.triangle_materials.size(), 4u);
    EXPECT_TRUE(context.warnings().empty());
}

}  // namespace
}  // namespace ff::test
