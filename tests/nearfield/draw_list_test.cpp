#include "engine/nearfield/draw_list.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/worlds.h"

namespace ff::nearfield {
namespace {

std::vector<std::uint32_t> all_instances(const scene::StaticScene& scene) {
    std::vector<std::uint32_t> ids(scene.instances.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

std::uint64_t triangles_of(const DrawList& list) {
    std::uint64_t count = 0;
    for (const DrawCommand& command : list.commands)
        count += std::uint64_t(command.index_count / 3) * command.instance_count;
    return count;
}

TEST(DrawList, both_lists_draw_every_triangle_of_every_instance) {
    const scene::SceneData world = test::make_forest({.trees = 60});
    const scene::StaticScene scene = world.view();
    const SceneLayout layout = make_layout(scene);
    const auto ids = all_instances(scene);
    std::uint64_t expected = 0;
    for (const scene::Instance& instance : scene.instances) expected += scene.meshes[instance.mesh].triangle_count;

    std::vector<std::uint32_t> order(scene.materials.size());
    std::iota(order.begin(), order.end(), 0u);
    DrawList list;
    make_shaded_draw_list(scene, layout, {.instances = ids}, WorldPos(0.0), order, list);
    EXPECT_EQ(list.triangle_count, expected);
    EXPECT_EQ(triangles_of(list), expected);
    make_id_draw_list(scene, layout, {.instances = ids}, WorldPos(0.0), list);
    EXPECT_EQ(list.triangle_count, expected);
    EXPECT_EQ(triangles_of(list), expected);
}

TEST(DrawList, instances_of_one_mesh_share_a_command_and_each_has_a_record) {
    const scene::SceneData world = test::make_forest({.trees = 60});
    const scene::StaticScene scene = world.view();
    const SceneLayout layout = make_layout(scene);
    const auto ids = all_instances(scene);
    DrawList list;
    make_id_draw_list(scene, layout, {.instances = ids}, WorldPos(0.0), list);
    EXPECT_LT(list.commands.size(), 4 * scene.meshes.size());
    std::vector<int> drawn(scene.instances.size(), 0);
    for (const DrawCommand& command : list.commands) {
        for (std::uint32_t r = command.base_instance; r < command.base_instance + command.instance_count; ++r) {
            const scene::Instance& instance = scene.instances[list.records[r].instance];
            EXPECT_EQ(command.base_vertex, std::int32_t(scene.meshes[instance.mesh].first_vertex));
            ++drawn[list.records[r].instance];
        }
    }
    for (int count : drawn) EXPECT_GE(count, 1);
}

TEST(DrawList, transforms_are_relative_to_the_camera_and_exact_far_from_the_origin) {
    const WorldPos far_away(1.0e6, 30.0, -2.0e6);
    const scene::SceneData world = test::make_city({}, {.origin = far_away});
    const scene::StaticScene scene = world.view();
    const SceneLayout layout = make_layout(scene);
    const auto ids = all_instances(scene);
    const WorldPos camera = far_away + DVec3(12.25, 1.75, -7.5);
    DrawList list;
    make_id_draw_list(scene, layout, {.instances = ids}, camera, list);
    for (const InstanceRecord& record : list.records) {
        const scene::Instance& instance = scene.instances[record.instance];
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(record.relative_from_mesh[axis][3], float(instance.position[axis] - camera[axis]));
    }
}

TEST(DrawList, dynamic_instances_are_named_after_the_static_ones) {
    const scene::SceneData world = test::make_single_triangle({0, 0, -5}, {1, 0, -5}, {0, 1, -5});
    const scene::StaticScene scene = world.view();
    const SceneLayout layout = make_layout(scene);
    std::vector<scene::Instance> dynamic(2, scene.instances[0]);
    dynamic[1].position = {3.0, 4.0, 5.0};
    const std::uint32_t ids[] = {2};
    DrawList list;
    make_id_draw_list(scene, layout, {.instances = ids, .dynamic = dynamic}, WorldPos(1.0), list);
    ASSERT_EQ(list.records.size(), 1u);
    EXPECT_EQ(list.records[0].instance, 2u);
    EXPECT_EQ(list.records[0].relative_from_mesh[2][3], 4.0f);
}

TEST(DrawList, a_steady_view_allocates_nothing) {
    const scene::SceneData world = test::make_forest({.trees = 60});
    const scene::StaticScene scene = world.view();
    const SceneLayout layout = make_layout(scene);
    const auto ids = all_instances(scene);
    DrawList list;
    make_id_draw_list(scene, layout, {.instances = ids}, WorldPos(0.0), list);
    const auto* records = list.records.data();
    const auto* commands = list.commands.data();
    for (int frame = 0; frame < 3; ++frame)
        make_id_draw_list(scene, layout, {.instances = ids}, WorldPos(double(frame)), list);
    EXPECT_EQ(list.records.data(), records);
    EXPECT_EQ(list.commands.data(), commands);
}

}  // namespace
}  // namespace ff::nearfield
