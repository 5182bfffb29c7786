// Animated models through packs; and what a pack may not say of them.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>

#include "engine/scene/animation_chunk.h"
#include "engine/scene/check_animation.h"
#include "engine/scene/load_world.h"
#include "engine/scene/save_world.h"
#include "tests/fuzz/touch_world.h"
#include "tests/support/animated_worlds.h"
#include "tests/support/temporary_folder.h"

namespace ff::scene {
namespace {

test::AnimatedSource small_source() {
    return test::make_animated_source({.worms = 2, .carts = 1, .worm = {.joints = 3, .rings = 4, .sides = 5}});
}

class TempPack {
  public:
    [[nodiscard]] std::filesystem::path path() const { return folder_ / "w.ffpack"; }

  private:
    test::TemporaryFolder folder_;
};

TEST(PackAnimation, a_loaded_world_moves_as_the_one_that_was_written) {
    const test::AnimatedSource source = small_source();
    const TempPack pack;
    const auto written = write_world(pack.path(), source.scene, source.info);
    ASSERT_TRUE(written) << written.error().message;
    auto loaded = load_world(pack.path());
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(animation_to_bytes((*loaded)->info().animation), animation_to_bytes(source.info.animation));
    EXPECT_EQ((*loaded)->info().animation.instances, source.info.animation.instances);

    // Poses are copies of the skinned mesh, behind everything that the pack has.
    const StaticScene& scene = (*loaded)->scene();
    const PoseRoom& room = (*loaded)->pose_room();
    ASSERT_EQ(room.slots.size(), 1u);
    EXPECT_EQ(room.slots[0].count, kMostPoses);
    EXPECT_EQ(scene.posed_mesh_count, kMostPoses);
    EXPECT_EQ(scene.meshes.size(), source.scene.meshes.size() + kMostPoses);
    const Mesh& bound = scene.meshes[room.slots[0].mesh];
    for (std::uint32_t i = 0; i < room.slots[0].count; ++i) {
        const Mesh& pose = scene.meshes[room.slots[0].first + i];
        EXPECT_EQ(pose.first_triangle, bound.first_triangle);
        EXPECT_GE(pose.first_vertex, source.scene.positions.size());
        EXPECT_EQ(std::memcmp(&scene.positions[pose.first_vertex], &scene.positions[bound.first_vertex],
                              bound.vertex_count * sizeof(Vec3)),
                  0);
        EXPECT_EQ(std::memcmp(&scene.mesh_leaves[pose.first_leaf], &scene.mesh_leaves[bound.first_leaf],
                              bound.leaf_count * sizeof(BvhLeaf)),
                  0);
    }
    EXPECT_EQ(scene.positions.size(), scene.attributes.size());
    test::touch_world(**loaded);
    EXPECT_EQ((*loaded)->statistics().vertices, source.scene.positions.size());
}

TEST(PackAnimation, a_world_without_has_no_chunk_of_it_and_no_room) {
    const SceneData scene = test::make_single_triangle(Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 0));
    const TempPack pack;
    ASSERT_TRUE(write_world(pack.path(), scene, {.name = "still"}));
    const auto reader = assets::PackReader::open(pack.path());
    ASSERT_TRUE(reader);
    EXPECT_EQ(reader->find("animation"), nullptr);
    auto loaded = load_world(pack.path());
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ((*loaded)->scene().posed_mesh_count, 0u);
    EXPECT_TRUE((*loaded)->pose_room().slots.empty());
}

TEST(PackAnimation, broken_promises_are_found) {
    const test::AnimatedSource good = small_source();
    ASSERT_FALSE(find_animation_problem(good.info.animation, good.scene.meshes));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::pair<const char*, std::function<void(AnimationSet&)>> spoils[] = {
        {"hangs on", [](auto& s) { s.models[0].skeleton.parents[1] = 1; }},
        {"differ in length", [](auto& s) { s.models[0].skeleton.names.pop_back(); }},
        {"joints; expected 1", [](auto& s) { s.models[1].skeleton = {}; }},
        {"rest pose", [=](auto& s) { s.models[0].skeleton.translations[1].x = nan; }},
        {"rest pose", [](auto& s) { s.models[0].skeleton.rotations[1] = Quat(0, 0, 0, 0); }},
        {"clip's name", [](auto& s) { s.models[0].clips[0].name.clear(); }},
        {"names of their own", [](auto& s) { s.models[0].clips[0].name = s.models[0].clips[1].name; }},
        {"joint 99", [](auto& s) { s.models[0].clips[0].tracks[2].joint = 99; }},
        {"outside the clip's", [](auto& s) { s.models[0].clips[0].tracks[0].first_value = 1u << 31; }},
        {"outside the clip's", [](auto& s) { s.models[0].clips[0].tracks[0].key_count = 0xFFFFFFFFu; }},
        {"outside the clip's", [](auto& s) { s.models[0].clips[0].tracks[0].key_count = 0; }},
        {"ascending times", [](auto& s) { s.models[0].clips[0].times[1] = 0.0f; }},
        {"ascending times", [=](auto& s) { s.models[0].clips[0].times[1] = nan; }},
        {"do not ascend",
         [](auto& s) { s.models[0].clips[0].tracks[0].even = true, s.models[0].clips[0].times[1] = -1; }},
        {"not finite", [=](auto& s) { s.models[0].clips[0].values[3] = nan; }},
        {"unknown", [](auto& s) { s.models[0].clips[0].tracks[0].path = TrackPath(7); }},
        {"out of order", [](auto& s) { std::swap(s.models[0].clips[0].tracks[0], s.models[0].clips[0].tracks[1]); }},
        {"part 1", [](auto& s) { s.models[1].parts[1].mesh = 1000; }},
        {"part 1", [](auto& s) { s.models[1].parts[1].joint = 3; }},
        {"mesh 1000", [](auto& s) { s.models[0].skins[0].mesh = 1000; }},
        {"one each", [](auto& s) { s.models[0].skins[0].joint_from_mesh.pop_back(); }},
        {"joint 50", [](auto& s) { s.models[0].skins[0].joints[0] = 50; }},
        {"inverse bind", [=](auto& s) { s.models[0].skins[0].joint_from_mesh[0][3].y = nan; }},
        {"influences", [](auto& s) { s.models[0].skins[0].influences = 9; }},
        {"the mesh's vertices", [](auto& s) { s.models[0].skins[0].vertex_joints.pop_back(); }},
        {"follows joint", [](auto& s) { s.models[0].skins[0].vertex_joints[0] = 65535; }},
        {"below 0", [=](auto& s) { s.models[0].skins[0].vertex_weights[0] = nan; }},
        {"sum to", [](auto& s) { s.models[0].skins[0].vertex_weights[0] += 0.5f; }},
        {"model 7", [](auto& s) { s.instances[0].model = 7; }},
        {"clip 7", [](auto& s) { s.instances[0].clip = 7; }},
        {"phase", [](auto& s) { s.instances[0].phase = 1.0; }},
        {"position", [](auto& s) { s.instances[0].position.x = 1e12; }},
        {"inverted", [](auto& s) { s.instances[0].world_from_model = Mat3(0.0f); }},
        {"has a skin already", [](auto& s) { s.models.push_back(s.models[0]); }},
    };
    for (const auto& [says, spoil] : spoils) {
        AnimationSet set = good.info.animation;
        spoil(set);
        const auto problem = find_animation_problem(set, good.scene.meshes);
        ASSERT_TRUE(problem) << says;
        EXPECT_NE(problem->what.find(says), std::string::npos) << problem->what;
    }
}

TEST(PackAnimation, a_chunk_with_any_byte_changed_or_cut_is_read_or_refused) {
    const test::AnimatedSource source = small_source();
    const std::vector<std::uint8_t> good = animation_to_bytes(source.info.animation);
    AnimationSet read;
    ASSERT_EQ(animation_from_bytes(good, read), "");
    for (std::size_t i = 0; i < good.size(); ++i)
        for (const unsigned change : {0x01u, 0x80u, 0xFFu}) {
            std::vector<std::uint8_t> bad = good;
            bad[i] = std::uint8_t(bad[i] ^ change);
            AnimationSet set;
            if (animation_from_bytes(bad, set).empty()) (void)find_animation_problem(set, source.scene.meshes);
        }
    for (std::size_t size = 0; size < good.size(); ++size) {
        const std::vector<std::uint8_t> cut(good.begin(), good.begin() + std::ptrdiff_t(size));
        AnimationSet set;
        if (animation_from_bytes(cut, set).empty()) (void)find_animation_problem(set, source.scene.meshes);
    }
}

}  // namespace
}  // namespace ff::scene
