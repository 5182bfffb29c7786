// Spawn points and standard walks in small worlds: free of walls, on the ground, without jumps, the same every time.

#include "tools/cook/walks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "engine/core/jobs.h"
#include "tests/cook/cook_worlds.h"
#include "tests/support/temporary_folder.h"

namespace ff::test {
namespace {

void add_box(cook::WorldSource& world, const DVec3& center, const Vec3& half) {
    world.placements.push_back({.mesh = add_mesh(world, box_mesh(half, 0)), .position = center});
}

// A square of ground, triangles of `spacing_m`, at the heights of a function.
template <class Height>
void add_ground(cook::WorldSource& world, double half_m, int cells, Height&& height) {
    scene::MeshSource mesh;
    for (int z = 0; z <= cells; ++z)
        for (int x = 0; x <= cells; ++x) {
            const double px = half_m * (2.0 * x / cells - 1.0), pz = half_m * (2.0 * z / cells - 1.0);
            mesh.positions.emplace_back(px, height(px, pz), pz);
            mesh.attributes.push_back({.normal_oct = {0, 0}, .uv = {0, 0}, .color = 0xFFFFFFFFu});
        }
    for (int z = 0; z < cells; ++z)
        for (int x = 0; x < cells; ++x) {
            const auto a = static_cast<std::uint32_t>(z * (cells + 1) + x), b = a + 1;
            const auto c = a + static_cast<std::uint32_t>(cells) + 1, d = c + 1;
            mesh.indices.insert(mesh.indices.end(), {a, c, b, b, c, d});
            mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, 0);
        }
    world.placements.push_back({.mesh = add_mesh(world, std::move(mesh))});
}

cook::WorldSource plain_world() {
    cook::WorldSource world;
    add_plain_material(world);
    return world;
}

// Blocks of 30 m with streets of 12 m between them.
std::vector<DBox3> add_blocks(cook::WorldSource& world) {
    std::vector<DBox3> boxes;
    for (int z = -3; z <= 3; ++z)
        for (int x = -3; x <= 3; ++x) {
            const DVec3 center(42.0 * x, 10.0, 42.0 * z);
            add_box(world, center, Vec3(15.0f, 10.0f, 15.0f));
            boxes.push_back({center - DVec3(15.0, 10.0, 15.0), center + DVec3(15.0, 10.0, 15.0)});
        }
    return boxes;
}

cook::WorldSource with_walks(cook::WorldSource world) {
    cook::CookCache none;
    cook::add_spawn_and_walks(world, false, none);
    return world;
}

const cook::SourceWalk& walk_of(const cook::WorldSource& world, const std::string& name) {
    for (const cook::SourceWalk& walk : world.walks)
        if (walk.name == name) return walk;
    ADD_FAILURE() << "no walk " << name;
    return world.walks.front();
}

// What formats.md and a player's stomach ask for.
void expect_natural_walks(const cook::WorldSource& world) {
    struct Expected {
        const char* name;
        std::size_t frames;
        double fastest_m_s;
    };
    for (const Expected& expected : {Expected{"street", 400, 3.5},
                                     {"orbit", 120, 1e4},
                                     {"flyover", 400, 30.0},
                                     {"turn", 180, 0.0},
                                     {"sprint", 200, 11.0}}) {
        SCOPED_TRACE(expected.name);
        const cook::SourceWalk& walk = walk_of(world, expected.name);
        ASSERT_EQ(walk.frames.size(), expected.frames);
        for (std::size_t f = 0; f < walk.frames.size(); ++f) {
            const cook::WalkFrame& frame = walk.frames[f];
            ASSERT_TRUE(std::isfinite(frame.position.x + frame.position.y + frame.position.z)) << f;
            ASSERT_GE(frame.pitch_deg, -90.0);
            ASSERT_LE(frame.pitch_deg, 90.0);
            if (f == 0) continue;
            const DVec3 moved = frame.position - walk.frames[f - 1].position;
            const double speed = std::sqrt(moved.x * moved.x + moved.y * moved.y + moved.z * moved.z) * 30.0;
            ASSERT_LE(speed, expected.fastest_m_s + 1e-3) << "frame " << f;
            const double turned = std::abs(std::remainder(frame.yaw_deg - walk.frames[f - 1].yaw_deg, 360.0));
            ASSERT_LE(turned, 3.001) << "frame " << f;
        }
    }
}

TEST(Walks, in_a_town_keep_away_from_all_walls_and_turn_a_corner) {
    cook::WorldSource world = plain_world();
    add_ground(world, 160.0, 40, [](double, double) { return 0.0; });
    const std::vector<DBox3> boxes = add_blocks(world);
    world = with_walks(std::move(world));
    expect_natural_walks(world);
    EXPECT_NEAR(world.spawn_position.y, 0.0, 0.01);
    for (const cook::SourceWalk& walk : world.walks)
        for (std::size_t f = 0; f < walk.frames.size(); ++f)
            for (const DBox3& box : boxes)
                ASSERT_GE(distance_to(box, walk.frames[f].position), 0.8) << walk.name << " frame " << f;
    double lowest = 1e9, highest = -1e9, yaw = 0;
    const auto& street = walk_of(world, "street").frames;
    for (std::size_t f = 1; f < street.size(); ++f) {
        EXPECT_NEAR(street[f].position.y, 1.7, 0.01);
        yaw += std::remainder(street[f].yaw_deg - street[f - 1].yaw_deg, 360.0);
        lowest = std::min(lowest, yaw), highest = std::max(highest, yaw);
    }
    EXPECT_GT(highest - lowest, 50.0) << "no corner";
    double top = 0;
    for (const auto& frame : walk_of(world, "flyover").frames) top = std::max(top, frame.position.y);
    EXPECT_GT(top, 40.0);
}

TEST(Walks, in_a_city_without_ground_run_between_the_houses) {
    cook::WorldSource world = plain_world();
    const std::vector<DBox3> boxes = add_blocks(world);
    world = with_walks(std::move(world));
    expect_natural_walks(world);
    EXPECT_NEAR(world.spawn_position.y, 0.0, 0.5);
    for (const auto& frame : walk_of(world, "street").frames) {
        EXPECT_NEAR(frame.position.y, 1.7, 0.5);
        for (const DBox3& box : boxes) ASSERT_GE(distance_to(box, frame.position), 0.8);
    }
}

TEST(Walks, on_slopes_follow_the_ground_at_eye_height) {
    cook::WorldSource world = plain_world();
    const auto height = [](double x, double z) { return 8.0 * std::sin(x / 40.0) + 0.1 * z; };
    add_ground(world, 300.0, 150, height);
    world = with_walks(std::move(world));
    expect_natural_walks(world);
    for (const char* name : {"street", "sprint"})
        for (const auto& frame : walk_of(world, name).frames)
            ASSERT_NEAR(frame.position.y - height(frame.position.x, frame.position.z), 1.7, 0.35) << name;
    for (const auto& frame : walk_of(world, "flyover").frames)
        ASSERT_GT(frame.position.y, height(frame.position.x, frame.position.z) + 1.2);
}

TEST(Walks, on_a_flat_plain_of_two_triangles_are_natural) {
    cook::WorldSource world = plain_world();
    add_ground(world, 5000.0, 1, [](double, double) { return 12.0; });
    world = with_walks(std::move(world));
    expect_natural_walks(world);
    EXPECT_NEAR(walk_of(world, "street").frames[0].position.y, 13.7, 0.01);
}

TEST(Walks, in_a_small_yard_go_back_and_forth) {
    cook::WorldSource world = plain_world();
    add_ground(world, 10.0, 4, [](double, double) { return 0.0; });
    world = with_walks(std::move(world));
    expect_natural_walks(world);
    for (const auto& frame : walk_of(world, "sprint").frames) {
        EXPECT_LT(std::abs(frame.position.x), 10.0);
        EXPECT_LT(std::abs(frame.position.z), 10.0);
    }
}

TEST(Walks, of_an_empty_world_are_there_and_keep_the_origin) {
    const cook::WorldSource world = with_walks(plain_world());
    EXPECT_EQ(world.spawn_position, DVec3(0.0));
    expect_natural_walks(world);
}

TEST(Walks, of_a_single_object_go_around_it_and_look_at_it) {
    for (const float half : {0.02f, 1.0f, 6.0f}) {
        cook::WorldSource world = plain_world();
        add_box(world, DVec3(100.0, 5.0, -40.0), Vec3(half));
        world = with_walks(std::move(world));
        expect_natural_walks(world);
        for (const char* name : {"street", "sprint", "flyover", "orbit"})
            for (const auto& frame : walk_of(world, name).frames) {
                const DVec3 d = frame.position - DVec3(100.0, 5.0, -40.0);
                ASSERT_GT(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}), double(half)) << name;
            }
    }
}

TEST(Walks, pass_through_grass_but_not_through_hedges) {
    cook::WorldSource world = plain_world();
    world.materials.push_back({.flags = scene::kMaterialAlphaMask});
    add_ground(world, 60.0, 20, [](double, double) { return 0.0; });
    const std::uint32_t hedge = add_mesh(world, box_mesh(Vec3(0.5f, 1.0f, 60.0f), 1));
    const std::uint32_t grass = add_mesh(world, box_mesh(Vec3(20.0f, 0.2f, 20.0f), 1));
    world.placements.push_back({.mesh = hedge, .position = DVec3(25.0, 1.0, 0.0)});
    world.placements.push_back({.mesh = grass, .position = DVec3(0.0, 0.2, 0.0)});
    world = with_walks(std::move(world));
    expect_natural_walks(world);
    for (const auto& frame : walk_of(world, "sprint").frames) EXPECT_GT(std::abs(frame.position.x - 25.0), 1.2);
}

TEST(Walks, are_the_same_for_any_number_of_workers_and_every_time) {
    const auto build = [](int workers) {
        const WorkerLimit limit(workers);
        cook::WorldSource world = scattered_triangles(3, 2000, 200.0, DVec3(1e5, 20.0, -3e5));
        add_ground(world, 100.0, 30, [](double x, double) { return 0.02 * x; });
        world.placements.back().position = DVec3(1e5, -30.0, -3e5);
        return with_walks(std::move(world));
    };
    const cook::WorldSource once = build(1), again = build(2);
    EXPECT_EQ(once.spawn_position, again.spawn_position);
    ASSERT_EQ(once.walks.size(), again.walks.size());
    for (std::size_t w = 0; w < once.walks.size(); ++w)
        for (std::size_t f = 0; f < once.walks[w].frames.size(); ++f) {
            const cook::WalkFrame &a = once.walks[w].frames[f], &b = again.walks[w].frames[f];
            ASSERT_EQ(a.position, b.position) << once.walks[w].name << " frame " << f;
            ASSERT_EQ(a.yaw_deg, b.yaw_deg);
            ASSERT_EQ(a.pitch_deg, b.pitch_deg);
        }
}

TEST(Walks, that_are_there_already_are_kept) {
    cook::WorldSource world = plain_world();
    add_ground(world, 50.0, 10, [](double, double) { return 0.0; });
    world.walks.push_back({.name = "street", .frames = {{.position = DVec3(1.0, 2.0, 3.0)}}});
    world = with_walks(std::move(world));
    ASSERT_EQ(world.walks.size(), 5u);
    EXPECT_EQ(walk_of(world, "street").frames.size(), 1u);
}

TEST(Walks, of_worlds_with_numbers_that_are_none_still_come) {
    cook::WorldSource world = plain_world();
    add_ground(world, 50.0, 10, [](double, double) { return 0.0; });
    world.meshes[0].geometry.positions[7] = Vec3(std::nanf(""));
    world.meshes[0].geometry.positions[40].y = std::numeric_limits<float>::infinity();
    expect_natural_walks(with_walks(std::move(world)));
}

TEST(WalkFiles, become_source_walks_or_say_what_is_wrong) {
    const test::TemporaryFolder folder;
    const auto path = folder / "ff_walks_test.walk.json";
    std::ofstream(path)
        << R"({"format": 1, "fov_deg": 70, "rate_hz": 60, "frames": [{"p": [1, 2, 3], "yaw_deg": 90}]})";
    const auto walk = cook::read_walk_file(path, "main");
    ASSERT_TRUE(walk) << walk.error().message;
    EXPECT_EQ(walk->name, "main");
    EXPECT_EQ(walk->fov_deg, 70.0);
    EXPECT_EQ(walk->rate_hz, 60.0);
    ASSERT_EQ(walk->frames.size(), 1u);
    EXPECT_EQ(walk->frames[0].position, DVec3(1.0, 2.0, 3.0));
    EXPECT_EQ(walk->frames[0].yaw_deg, 90.0);
    std::ofstream(path) << R"({"format": 1, "frames": 7})";
    const auto broken = cook::read_walk_file(path, "main");
    ASSERT_FALSE(broken);
    EXPECT_EQ(broken.error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace ff::test
