// Skeletons, skins and clips out of documents; and broken ones.

#include <cmath>
#include <functional>

#include "tests/cook/gltf_builder.h"
#include "tools/cook/assemble.h"

namespace ff::test {
namespace {

using scene::Interpolation;
using scene::TrackPath;

/// Two joints, the second 1 m above the first, and a quad whose lower edge follows the one, its upper edge the other.
/// Animation "wave" turns the second. Nodes: 0 shows the mesh, 1 and 2 are the joints.
GltfBuilder skinned_quad() {
    GltfBuilder b;
    const int positions = b.add_positions({0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0});
    const int joints =
        b.add_accessor(b.add_view<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}), 5121, "VEC4", 4);
    const int weights = b.add_accessor(
        b.add_view<std::uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 200, 55, 0, 0}), 5121, "VEC4", 4, true);
    const int indices = b.add_accessor(b.add_view<std::uint16_t>({0, 1, 2, 0, 2, 3}), 5123, "SCALAR", 6);
    b.add_mesh({{"attributes", {{"POSITION", positions}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}},
                {"indices", indices}});
    const std::vector<float> binds = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                      1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1};
    const int matrices = b.add_accessor(b.add_view(binds), 5126, "MAT4", 2);
    b.document["skins"] = json::array({{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}});
    b.add_node({{"mesh", 0}, {"skin", 0}, {"translation", {5, 5, 5}}});  // which the skin overrides
    b.add_node({{"name", "hip"}, {"children", {2}}});
    b.document["nodes"].push_back({{"name", "tip"}, {"translation", {0, 1, 0}}});
    const int times = b.add_accessor(b.add_view<float>({0, 0.5f, 1}), 5126, "SCALAR", 3);
    const int turns = b.add_accessor(b.add_view<std::int16_t>({0, 0, 0, 32767, 0, 0, 23170, 23170, 0, 0, 0, 32767}),
                                     5122, "VEC4", 3, true);
    b.document["animations"] =
        json::array({{{"name", "wave"},
                      {"samplers", json::array({{{"input", times}, {"output", turns}}})},
                      {"channels", json::array({{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}})}}});
    return b;
}

class GltfAnimated : public GltfTest {
  protected:
    struct Animated {
        cook::WorldSource world;
        cook::CookCache cache;
        cook::CookContext context{cache};
        Result<cook::Model> model;
        explicit Animated(const std::filesystem::path& path)
            : model(cook::import_gltf(path, world, context, cook::ModelKind::animated)) {}
        [[nodiscard]] const scene::AnimatedModel& animated() const { return world.animation.models.at(0); }
    };
    Animated import(GltfBuilder builder) {
        write_bytes(folder_ / "model.glb", builder.glb());
        return Animated(folder_ / "model.glb");
    }
    void expect_error(const std::function<void(GltfBuilder&)>& spoil, const std::string& place) {
        GltfBuilder builder = skinned_quad();
        spoil(builder);
        Animated in = import(builder);
        ASSERT_FALSE(in.model) << place;
        EXPECT_EQ(in.model.error().kind, ErrorKind::bad_input);
        EXPECT_NE(in.model.error().message.find(place), std::string::npos) << in.model.error().message;
        EXPECT_NE(in.model.error().message.find("expected"), std::string::npos) << in.model.error().message;
        EXPECT_TRUE(in.world.meshes.empty() && in.world.materials.empty() && in.world.animation.models.empty());
    }
};

TEST_F(GltfAnimated, a_skin_follows_its_joints_and_not_its_node) {
    Animated in = import(skinned_quad());
    ASSERT_TRUE(in.model) << in.model.error().message;
    ASSERT_EQ(in.model->animated, 0u);
    EXPECT_TRUE(in.model->parts.empty());
    const scene::AnimatedModel& model = in.animated();
    ASSERT_EQ(model.skeleton.size(), 3u);
    EXPECT_EQ(model.skeleton.names, (std::vector<std::string>{"", "hip", "tip"}));
    EXPECT_EQ(model.skeleton.parents, (std::vector<std::uint32_t>{scene::kNoJoint, scene::kNoJoint, 1u}));
    ASSERT_EQ(model.skins.size(), 1u);
    const scene::Skin& skin = model.skins[0];
    EXPECT_EQ(skin.joints, (std::vector<std::uint32_t>{1, 2}));
    EXPECT_EQ(skin.influences, 2u);
    EXPECT_EQ(skin.joint_from_mesh[1][3], Vec3(0, -1, 0));
    for (std::size_t v = 0; v < skin.vertex_weights.size() / 2; ++v)
        EXPECT_NEAR(skin.vertex_weights[2 * v] + skin.vertex_weights[2 * v + 1], 1.0f, 1e-6f);
    EXPECT_NEAR(in.model->bounds.high.y, 2.0, 1e-6);
    EXPECT_NEAR(in.model->bounds.high.x, 1.0, 1e-6);
}

TEST_F(GltfAnimated, clips_are_read_whatever_type_their_numbers_have) {
    GltfBuilder builder = skinned_quad();
    // A second, nameless one: cubic, of translations.
    const int times = builder.add_accessor(builder.add_view<float>({0.25f, 2}), 5126, "SCALAR", 2);
    const int values = builder.add_accessor(
        builder.add_view<float>({0, 0, 0, 0, 1, 0, 0, 3, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0}), 5126, "VEC3", 6);
    builder.document["animations"].push_back(
        {{"samplers", json::array({{{"input", times}, {"output", values}, {"interpolation", "CUBICSPLINE"}}})},
         {"channels", json::array({{{"sampler", 0}, {"target", {{"node", 2}, {"path", "translation"}}}}})}});
    Animated in = import(builder);
    ASSERT_TRUE(in.model) << in.model.error().message;
    const auto& clips = in.animated().clips;
    ASSERT_EQ(clips.size(), 2u);
    EXPECT_EQ(clips[0].name, "wave");
    EXPECT_FLOAT_EQ(clips[0].duration_s, 1.0f);
    ASSERT_EQ(clips[0].tracks.size(), 1u);
    EXPECT_EQ(clips[0].tracks[0].joint, 2u);
    EXPECT_NEAR(clips[0].values[6], std::sqrt(0.5f), 1e-4f);
    EXPECT_EQ(clips[1].name, "clip1");
    EXPECT_EQ(clips[1].tracks[0].interpolation, Interpolation::cubic);
    EXPECT_EQ(clips[1].values.size(), 18u);
}

TEST_F(GltfAnimated, sparse_weights_and_missing_inverse_binds_are_read) {
    GltfBuilder builder = skinned_quad();
    builder.document["skins"][0].erase("inverseBindMatrices");
    const int index = builder.add_view<std::uint16_t>({3});
    const int value = builder.add_view<std::uint8_t>({0, 255, 0, 0});
    builder.document["accessors"][2]["sparse"] = {{"count", 1},
                                                  {"indices", {{"bufferView", index}, {"componentType", 5123}}},
                                                  {"values", {{"bufferView", value}}}};
    Animated in = import(builder);
    ASSERT_TRUE(in.model) << in.model.error().message;
    EXPECT_EQ(in.animated().skins[0].joint_from_mesh[1], scene::Mat4x3(1.0f));
    EXPECT_EQ(in.animated().skins[0].influences, 1u) << "the only vertex with two now follows one";
}

TEST_F(GltfAnimated, vertices_in_one_place_that_follow_other_joints_stay_apart) {
    GltfBuilder b = skinned_quad();
    // Two triangles over the same three places, one for each joint.
    b.document["accessors"][0]["count"] = 4;
    const int positions = b.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int normals = b.add_positions({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    std::vector<std::uint8_t> joints, weights;
    for (int v = 0; v < 6; ++v)
        for (int i = 0; i < 4; ++i) {
            joints.push_back(i == 0 && v >= 3 ? 1 : 0);
            weights.push_back(i == 0 ? 255 : 0);
        }
    b.document["meshes"][0]["primitives"][0] = {
        {"attributes",
         {{"POSITION", positions},
          {"NORMAL", normals},
          {"JOINTS_0", b.add_accessor(b.add_view(joints), 5121, "VEC4", 6)},
          {"WEIGHTS_0", b.add_accessor(b.add_view(weights), 5121, "VEC4", 6, true)}}}};
    Animated in = import(b);
    ASSERT_TRUE(in.model) << in.model.error().message;
    in.world.meshes.push_back(in.world.meshes[0]);  // and something that stands still
    in.world.placements.push_back({.mesh = 1});
    in.world.animation.instances.push_back({.model = 0});
    auto assembly = cook::assemble(std::move(in.world), {}, in.context);
    ASSERT_TRUE(assembly) << assembly.error().message;
    const scene::Skin& skin = assembly->info.animation.models[0].skins[0];
    ASSERT_EQ(assembly->scene.meshes[skin.mesh].vertex_count, 6u);
    EXPECT_EQ(std::count(skin.vertex_joints.begin(), skin.vertex_joints.end(), 1), 3);
}

TEST_F(GltfAnimated, nodes_that_move_keep_their_meshes_whole) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["nodes"][0]["name"] = "wheel";
    const int times = builder.add_accessor(builder.add_view<float>({0, 1}), 5126, "SCALAR", 2);
    const int scales = builder.add_accessor(builder.add_view<float>({1, 1, 1, 2, 2, 2}), 5126, "VEC3", 2);
    builder.document["animations"] =
        json::array({{{"samplers", json::array({{{"input", times}, {"output", scales}, {"interpolation", "STEP"}}})},
                      {"channels", json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}})}}});
    Animated in = import(builder);
    ASSERT_TRUE(in.model) << in.model.error().message;
    ASSERT_EQ(in.animated().parts.size(), 1u);
    EXPECT_EQ(in.animated().clips[0].tracks[0].interpolation, Interpolation::step);
    EXPECT_EQ(in.animated().clips[0].tracks[0].path, TrackPath::scale);
    EXPECT_EQ(scene::find_joint(in.animated().skeleton, "wheel"), 0u);
}

TEST_F(GltfAnimated, a_still_model_says_once_that_it_does_not_move) {
    write_bytes(folder_ / "model.glb", skinned_quad().glb());
    Imported in(folder_ / "model.glb");
    ASSERT_TRUE(in.model) << in.error();
    EXPECT_FALSE(in.model->animated);
    std::string all;
    for (const std::string& warning : in.context.warnings()) all += warning + "\n";
    EXPECT_NE(all.find("has animations, and is not dynamic"), std::string::npos) << all;
    EXPECT_NE(all.find("has skins, and is not dynamic"), std::string::npos) << all;
}

TEST_F(GltfAnimated, a_dynamic_model_without_either_is_as_before) {
    Animated in = import(GltfBuilder::triangle());
    ASSERT_TRUE(in.model) << in.model.error().message;
    EXPECT_FALSE(in.model->animated);
    EXPECT_EQ(in.model->parts.size(), 1u);
}

TEST_F(GltfAnimated, broken_skins_are_named_where_they_are_broken) {
    const auto set = [](const char* pointer, const json& value) {
        return [=](GltfBuilder& b) { b.document[json::json_pointer(pointer)] = value; };
    };
    expect_error(set("/nodes/0/skin", 3), "nodes[0].skin: 3");
    expect_error(set("/skins/0/joints/1", 17), "skins[0].joints[1]: 17");
    expect_error(set("/skins/0/joints", json::array()), "skins[0].joints");
    expect_error(set("/skins/0/inverseBindMatrices", 99), "skins[0].inverseBindMatrices: 99");
    expect_error(set("/skins/0/inverseBindMatrices", 0), "skins[0].inverseBindMatrices");
    expect_error(set("/accessors/4/count", 1), "skins[0].inverseBindMatrices: 1 matrices");
    expect_error(set("/skins/0/joints", json::array({1})), "JOINTS_0: element 2");
    expect_error(set("/accessors/1/count", 2), "JOINTS");
    expect_error(set("/accessors/1/type", "VEC3"), "JOINTS_0");
    expect_error(set("/nodes/2/children", json::array({1})), "ancestor of itself");
    expect_error([](GltfBuilder& b) { b.document["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0"); },
                 "JOINTS_0 without WEIGHTS_0");
    expect_error([](GltfBuilder& b) { b.document["scenes"][0]["nodes"] = json::array({0}); }, "skins[0].joints[0]");
    expect_error(
        [](GltfBuilder& b) {
            const float nan = std::numeric_limits<float>::quiet_NaN();
            const std::vector<float> bad(16, nan);
            b.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] =
                b.add_accessor(b.add_view(bad), 5126, "VEC4", 4);
        },
        "WEIGHTS_0: element 0");
    expect_error(
        [](GltfBuilder& b) {
            const std::vector<float> bad(16, -0.25f);
            b.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] =
                b.add_accessor(b.add_view(bad), 5126, "VEC4", 4);
        },
        "WEIGHTS_0: element 0");
}

TEST_F(GltfAnimated, broken_animations_are_named_where_they_are_broken) {
    const auto set = [](const char* pointer, const json& value) {
        return [=](GltfBuilder& b) { b.document[json::json_pointer(pointer)] = value; };
    };
    expect_error(set("/animations/0/channels/0/sampler", 1), "animations[0].channels[0].sampler: 1");
    expect_error(set("/animations/0/channels/0/target/node", 9), "animations[0].channels[0].target.node: 9");
    expect_error(set("/animations/0/channels/0/target", 7), "animations[0].channels[0].target");
    expect_error(set("/animations/0/channels", 7), "animations[0].channels");
    expect_error(set("/animations/0/samplers/0/input", 77), "animations[0].samplers[0].input: 77");
    expect_error(set("/animations/0/samplers/0/interpolation", "BEZIER"), "interpolation");
    expect_error(set("/animations/0/samplers/0/interpolation", "CUBICSPLINE"), "samplers[0].output: 3 values");
    expect_error(set("/animations/0/samplers/0/output", 0), "samplers[0].output");
    expect_error(set("/accessors/6/count", 2), "samplers[0].output: 2 values");
    expect_error(
        [](GltfBuilder& b) {
            b.document["animations"][0]["channels"].push_back(b.document["animations"][0]["channels"][0]);
        },
        "animations[0].channels[1].target");
    const auto with_times = [](std::vector<float> times) {
        return [=](GltfBuilder& b) {
            b.document["animations"][0]["samplers"][0]["input"] =
                b.add_accessor(b.add_view(times), 5126, "SCALAR", times.size());
        };
    };
    expect_error(with_times({0, 1, 0.5f}), "samplers[0].input: element 2");
    expect_error(with_times({0, 1, 1}), "samplers[0].input: element 2");
    expect_error(with_times({-1, 0, 1}), "samplers[0].input: element 0");
    expect_error(with_times({0, std::numeric_limits<float>::infinity(), 2}), "samplers[0].input: element 1");
    expect_error(
        [](GltfBuilder& b) {
            const std::vector<float> zeros(12, 0.0f);
            b.document["animations"][0]["samplers"][0]["output"] = b.add_accessor(b.add_view(zeros), 5126, "VEC4", 3);
        },
        "a rotation of length 0");
}

}  // namespace
}  // namespace ff::test
