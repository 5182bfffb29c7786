#include "tools/cook/assemble.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/core/hash.h"
#include "engine/core/jobs.h"
#include "tests/cook/cook_worlds.h"
#include "tools/cook/assemble_cells.h"

namespace ff::test {
namespace {

using cook::Assembly;
using cook::PlacementKind;
using cook::WorldSource;

class Assemble : public testing::Test {
  protected:
    Result<Assembly> assemble(WorldSource world, const cook::AssembleSettings& settings = {.height_grid_size = 16}) {
        cook::CookContext context(cache_);
        return cook::assemble(std::move(world), settings, context);
    }
    cook::CookCache cache_;
};

using Triangle = std::array<DVec3, 3>;

// World corners from the least one on, so that triangles can be compared whatever order their corners have.
Triangle normalized(Triangle t) {
    const auto less = [](const DVec3& a, const DVec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
    std::sort(t.begin(), t.end(), less);
    return t;
}

std::vector<Triangle> world_triangles(const scene::StaticScene& scene) {
    std::vector<Triangle> all;
    for (const scene::Instance& instance : scene.instances) {
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
            Triangle triangle;
            for (std::size_t c = 0; c < 3; ++c) {
                const std::uint32_t index = scene.indices[3 * std::size_t{mesh.first_triangle + t} + c];
                triangle[c] = DMat3(instance.world_from_mesh) * DVec3(scene.positions[mesh.first_vertex + index]) +
                              instance.position;
            }
            all.push_back(normalized(triangle));
        }
    }
    return all;
}

std::vector<Triangle> world_triangles(const WorldSource& world) {
    std::vector<Triangle> all;
    for (const cook::Placement& placement : world.placements) {
        const scene::MeshSource& mesh = world.meshes[placement.mesh].geometry;
        for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
            Triangle triangle;
            for (std::size_t c = 0; c < 3; ++c)
                triangle[c] = DMat3(placement.world_from_mesh) * DVec3(mesh.positions[mesh.indices[3 * t + c]]) +
                              placement.position;
            all.push_back(normalized(triangle));
        }
    }
    return all;
}

std::uint64_t hash_of(const Assembly& assembly) {
    const scene::SceneData& s = assembly.scene;
    std::uint64_t hash = 0;
    const auto add = [&](const auto& array) { hash = hash_bytes(std::as_bytes(std::span(array)), hash); };
    add(s.positions), add(s.attributes), add(s.indices), add(s.triangle_materials), add(s.mesh_nodes);
    add(s.mesh_leaves), add(s.instance_nodes), add(s.heights), add(s.texels), add(s.prelit_colors), add(s.materials);
    for (const scene::Instance& instance : s.instances) {
        add(std::vector{instance.position});
        add(std::vector{instance.mesh, instance.cell});
    }
    return hash;
}

TEST_F(Assemble, every_triangle_arrives_once_where_it_was_even_1000_km_away) {
    for (const double away : {0.0, 1e6}) {
        const WorldSource world = scattered_triangles(1, 4000, 3000.0, {away, 10.0, -away});
        std::vector<Triangle> expected = world_triangles(world);
        const auto assembly = assemble(world, {.cell_triangles = 200, .height_grid_size = 16});
        ASSERT_TRUE(assembly) << assembly.error().message;
        std::vector<Triangle> found = world_triangles(assembly->scene.view());
        ASSERT_EQ(found.size(), expected.size());
        // Cells are at most a few kilometres off their triangles: float32 keeps a millimetre.
        const auto less = [](const Triangle& a, const Triangle& b) {
            const DVec3 ca = a[0] + a[1] + a[2], cb = b[0] + b[1] + b[2];
            return ca.x < cb.x;
        };
        std::sort(expected.begin(), expected.end(), less);
        std::sort(found.begin(), found.end(), less);
        for (std::size_t i = 0; i < found.size(); ++i)
            EXPECT_LT(glm::distance(found[i][0] + found[i][1] + found[i][2],
                                    expected[i][0] + expected[i][1] + expected[i][2]),
                      3e-3);
    }
}

TEST_F(Assemble, cells_hold_at_most_their_share_and_what_stands_in_them) {
    const cook::AssembleSettings settings{.cell_triangles = 100, .height_grid_size = 16};
    const auto assembly = assemble(scattered_triangles(2, 8000, 4000.0, {0, 0, 0}), settings);
    ASSERT_TRUE(assembly) << assembly.error().message;
    const scene::StaticScene scene = assembly->scene.view();
    EXPECT_GT(scene.cells.size(), 60u);
    std::uint64_t sum = 0;
    for (const scene::Cell& cell : scene.cells) {
        sum += cell.triangle_count;
        EXPECT_LE(cell.triangle_count, settings.cell_triangles);
        EXPECT_EQ(cell.origin, glm::round(cell.origin));
        for (std::uint32_t i = 0; i < cell.instance_count; ++i) {
            const scene::Instance& instance = scene.instances[cell.first_instance + i];
            EXPECT_EQ(instance.position, glm::round(instance.position)) << "whole metres";
            EXPECT_GE(instance.bounds.low.x, cell.bounds.low.x);
        }
    }
    EXPECT_EQ(sum, 8000u);
}

TEST_F(Assemble, the_number_of_workers_changes_no_byte) {
    std::uint64_t hashes[3];
    for (int workers = 1; workers <= 3; ++workers) {
        const WorkerLimit limit(workers);
        const auto assembly = assemble(scattered_triangles(3, 20000, 3000.0, {500, 0, 0}),
                                       {.cell_triangles = 500, .height_grid_size = 64});
        ASSERT_TRUE(assembly) << assembly.error().message;
        hashes[workers - 1] = hash_of(*assembly);
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST_F(Assemble, meshes_placed_often_stay_instances_and_others_are_merged) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world);
    scene::MeshSource big = box_mesh(Vec3(1), material);  // 12 triangles, four times over: 48
    for (int i = 0; i < 2; ++i) {
        const scene::MeshSource copy = big;
        const auto first = static_cast<std::uint32_t>(big.positions.size());
        for (const Vec3& p : copy.positions) big.positions.push_back(p + Vec3(0, 3 * (i + 1), 0));
        for (const std::uint32_t index : copy.indices) big.indices.push_back(first + index);
        big.attributes.insert(big.attributes.end(), copy.attributes.begin(), copy.attributes.end());
        big.triangle_materials.insert(big.triangle_materials.end(), copy.triangle_materials.begin(),
                                      copy.triangle_materials.end());
    }
    const std::uint32_t often = add_mesh(world, big), once = add_mesh(world, big),
                        tiny = add_mesh(world, box_mesh(Vec3(1), material));
    for (int i = 0; i < 5; ++i)
        world.placements.push_back({.mesh = often, .position = {10.0 * i, 0, 0}, .kind = PlacementKind::instance});
    world.placements.push_back({.mesh = once, .position = {0, 0, 50}, .kind = PlacementKind::instance});
    for (int i = 0; i < 3; ++i)
        world.placements.push_back({.mesh = tiny, .position = {10.0 * i, 0, 60}, .kind = PlacementKind::instance});
    const auto assembly = assemble(world);
    ASSERT_TRUE(assembly) << assembly.error().message;
    EXPECT_EQ(assembly->scene.meshes.size(), 2u) << "one cell, one instanced mesh";
    EXPECT_EQ(assembly->scene.instances.size(), 6u);
    EXPECT_EQ(assembly->scene.triangle_materials.size(), 48u + 48u + 3 * 12u);
    EXPECT_EQ(world_triangles(assembly->scene.view()).size(), 5 * 48u + 48u + 36u);
}

TEST_F(Assemble, mirrored_placements_face_outwards_still) {
    WorldSource world;
    const std::uint32_t box = add_mesh(world, box_mesh(Vec3(1, 2, 3), add_plain_material(world)));
    world.placements.push_back({.mesh = box, .world_from_mesh = Mat3(-2, 0, 0, 0, 1, 0.5f, 0, 0, 1)});
    const auto assembly = assemble(world);
    ASSERT_TRUE(assembly) << assembly.error().message;
    const scene::StaticScene scene = assembly->scene.view();
    for (std::size_t t = 0; t < 12; ++t) {
        const auto corner = [&](std::size_t c) { return scene.positions[scene.indices[3 * t + c]]; };
        const Vec3 normal = glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
        const Vec3 shaded = scene::decode_normal(scene.attributes[scene.indices[3 * t]].normal_oct);
        EXPECT_GT(glm::dot(normal, shaded), 0.999f);
    }
}

TEST_F(Assemble, equal_vertices_become_one_and_triangles_without_area_go) {
    WorldSource world;
    scene::MeshSource mesh = box_mesh(Vec3(1), add_plain_material(world));
    scene::MeshSource unshared;  // every corner a vertex of its own
    for (const std::uint32_t index : mesh.indices) {
        unshared.indices.push_back(static_cast<std::uint32_t>(unshared.positions.size()));
        unshared.positions.push_back(mesh.positions[index]);
        unshared.attributes.push_back(mesh.attributes[index]);
    }
    unshared.triangle_materials = mesh.triangle_materials;
    for (const std::uint32_t corner : {0u, 0u, 1u}) unshared.indices.push_back(corner);
    unshared.triangle_materials.push_back(0);
    world.placements.push_back({.mesh = add_mesh(world, unshared)});
    const auto assembly = assemble(world);
    ASSERT_TRUE(assembly) << assembly.error().message;
    EXPECT_EQ(assembly->scene.positions.size(), 24u);
    EXPECT_EQ(assembly->scene.triangle_materials.size(), 12u);
    EXPECT_EQ(assembly->dropped_triangles, 1u);
}

TEST_F(Assemble, equal_textures_and_materials_are_shared_and_unused_ones_left_out) {
    WorldSource world;
    for (int i = 0; i < 3; ++i) {
        world.textures.push_back({.name = "t",
                                  .content_hash = i < 2 ? "same" : "other",
                                  .width = 2,
                                  .height = 2,
                                  .rgba = std::vector<std::uint32_t>(4, 0xFF00FF00u)});
        world.materials.push_back({.base_color_texture = static_cast<std::uint32_t>(i)});
        if (i < 2)
            world.placements.push_back({.mesh = add_mesh(world, box_mesh(Vec3(1.0f + float(i)), std::uint16_t(i)))});
    }
    const auto assembly = assemble(world);
    ASSERT_TRUE(assembly) << assembly.error().message;
    EXPECT_EQ(assembly->scene.textures.size(), 1u);
    EXPECT_EQ(assembly->scene.materials.size(), 1u);
    EXPECT_EQ(assembly->scene.textures[0].level_count, 2u);
}

TEST_F(Assemble, dynamic_placements_become_the_worlds_dynamic_objects) {
    WorldSource world;
    const std::uint16_t material = add_plain_material(world);
    world.placements.push_back({.mesh = add_mesh(world, box_mesh(Vec3(50, 1, 50), material))});
    world.placements.push_back(
        {.mesh = add_mesh(world, box_mesh(Vec3(1), material)), .position = {3, 2, 1}, .kind = PlacementKind::dynamic});
    const auto assembly = assemble(world);
    ASSERT_TRUE(assembly) << assembly.error().message;
    ASSERT_EQ(assembly->info.dynamic_instances.size(), 1u);
    EXPECT_EQ(assembly->info.dynamic_instances[0].position, DVec3(3, 2, 1));
    EXPECT_EQ(assembly->scene.meshes[assembly->info.dynamic_instances[0].mesh].triangle_count, 12u);
    EXPECT_EQ(assembly->scene.instances.size(), 1u);
}

TEST_F(Assemble, placements_at_the_end_of_the_universe_are_errors) {
    WorldSource world;
    const std::uint32_t box = add_mesh(world, box_mesh(Vec3(1), add_plain_material(world)));
    world.placements.push_back({.mesh = box, .position = {2e9, 0, 0}});
    EXPECT_FALSE(assemble(world));
    world.placements[0] = {.mesh = box, .world_from_mesh = Mat3(0.0f)};
    EXPECT_FALSE(assemble(world));
    world.placements[0] = {.mesh = box, .world_from_mesh = Mat3(1e30f)};
    EXPECT_FALSE(assemble(world));
}

TEST_F(Assemble, an_empty_world_is_a_world) {
    EXPECT_TRUE(assemble(WorldSource{}));
}

TEST(CellGrid, squares_of_a_cell_are_consecutive_and_know_their_middle) {
    const cook::CellGrid grid(4096, 64);
    std::mt19937 random(5);
    std::vector<cook::CellEntry> entries;
    std::vector<DVec3> points;
    for (std::uint32_t i = 0; i < 5000; ++i) {
        const double x = (static_cast<double>(random()) / 4294967295.0 - 0.5) * 20000, z = std::sin(x) * 3000;
        entries.push_back({.square = grid.square_of(x, z), .id = i});
        points.emplace_back(x, 0, z);
    }
    std::size_t total = 0;
    for (const cook::CellRange& cell : grid.divide(entries, 20)) {
        total += cell.end - cell.begin;
        double reach = 0;
        for (std::size_t i = cell.begin; i < cell.end; ++i)
            reach = std::max(
                {reach, std::abs(points[entries[i].id].x - cell.x), std::abs(points[entries[i].id].z - cell.z)});
        EXPECT_LE(reach, 2048.0);
        EXPECT_TRUE(cell.end - cell.begin <= 20 || reach <= 32.0);
    }
    EXPECT_EQ(total, entries.size());
}

}  // namespace
}  // namespace ff::test
