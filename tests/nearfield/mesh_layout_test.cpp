#include "engine/nearfield/mesh_layout.h"

#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace ff::nearfield {
namespace {

scene::SceneData make_mixed_world() {
    scene::SceneData world = test::make_triangle_soup({.triangles = 300, .meshes = 4, .masked = true});
    return world;
}

TEST(MeshLayout, every_triangle_is_drawn_exactly_once) {
    const scene::SceneData world = make_mixed_world();
    const scene::StaticScene scene = world.view();
    const SceneLayout layout = make_layout(scene);
    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
        std::vector<int> seen(scene.meshes[m].triangle_count, 0);
        for (std::uint32_t t = 0; t < scene.meshes[m].triangle_count; ++t) ++seen[layout.triangle_of(m, t)];
        for (int count : seen) EXPECT_EQ(count, 1) << "mesh " << m;
    }
}

TEST(MeshLayout, groups_cover_a_mesh_in_layers_and_share_a_material) {
    const scene::SceneData world = make_mixed_world();
    const scene::StaticScene scene = world.view();
    const SceneLayout layout = make_layout(scene);
    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
        const MeshLayout& mesh = layout.meshes[m];
        std::uint32_t next = 0, opaque = 0;
        MaterialLayer last = MaterialLayer::opaque;
        for (std::uint32_t g = mesh.first_group; g < mesh.first_group + mesh.group_count; ++g) {
            const MaterialGroup& group = layout.groups[g];
            EXPECT_EQ(group.first_triangle, next);
            next += group.triangle_count;
            const MaterialLayer layer = layer_of(scene.materials[group.material]);
            EXPECT_GE(layer, last);
            last = layer;
            if (layer == MaterialLayer::opaque) opaque += group.triangle_count;
            for (std::uint32_t t = group.first_triangle; t < next; ++t)
                EXPECT_EQ(scene.triangle_materials[scene.meshes[m].first_triangle + layout.triangle_of(m, t)],
                          group.material);
        }
        EXPECT_EQ(next, scene.meshes[m].triangle_count);
        EXPECT_EQ(opaque, mesh.opaque_triangle_count);
    }
}

TEST(MeshLayout, an_empty_world_has_an_empty_layout) {
    const scene::SceneData world = test::make_empty_world();
    const SceneLayout layout = make_layout(world.view());
    EXPECT_TRUE(layout.groups.empty());
    EXPECT_TRUE(layout.reordered.empty());
}

}  // namespace
}  // namespace ff::nearfield
