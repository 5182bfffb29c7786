// What the importer makes of good documents, built by hand.

#include <meshoptimizer.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "tests/cook/gltf_builder.h"

namespace ff::test {
namespace {

using scene::MeshSource;

TEST_F(GltfTest, a_triangle_arrives_with_a_flat_normal_and_its_node) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["nodes"][0]["translation"] = {1000000.25, 2, 3};
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    ASSERT_EQ(in.model->parts.size(), 1u);
    EXPECT_EQ(in.model->parts[0].position, DVec3(1000000.25, 2, 3));
    EXPECT_EQ(in.model->triangle_count, 1u);
    ASSERT_EQ(in.mesh().indices.size(), 3u);
    EXPECT_EQ(in.mesh().positions[in.mesh().indices[1]], Vec3(1, 0, 0));
    const Vec3 normal = scene::decode_normal(in.mesh().attributes[0].normal_oct);
    EXPECT_LT(glm::distance(normal, Vec3(0, 0, 1)), 1e-4f);
    EXPECT_EQ(in.mesh().attributes[0].color, 0xFFFFFFFFu);
    EXPECT_EQ(in.model->bounds.high, DVec3(1000001.25, 3, 3));
}

TEST_F(GltfTest, hierarchies_multiply_in_double_and_mirrors_are_kept) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["nodes"] = json::array({{{"children", {1}}, {"translation", {1e6, 0, 0}}, {"scale", {2, 2, 2}}},
                                             {{"children", {2}}, {"scale", {-1, 1, 1}}},
                                             {{"mesh", 0}, {"translation", {0.125, 0, 0}}}});
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    EXPECT_EQ(in.model->parts.at(0).position, DVec3(1e6 - 0.25, 0, 0));
    EXPECT_LT(glm::determinant(in.model->parts[0].model_from_mesh), 0.0);
}

TEST_F(GltfTest, a_mesh_squeezed_flat_is_baked_and_one_squeezed_to_a_line_is_left_out) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["nodes"][0]["scale"] = {2, 3, 0};
    builder.add_node({{"mesh", 0}, {"scale", {1, 0, 0}}});
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    ASSERT_EQ(in.model->parts.size(), 1u);
    EXPECT_EQ(in.model->parts[0].model_from_mesh, DMat3(1.0));
    const MeshSource& mesh = in.mesh(in.model->parts[0].mesh);
    EXPECT_EQ(mesh.positions[mesh.indices[2]], Vec3(0, 3, 0));
    EXPECT_LT(glm::distance(scene::decode_normal(mesh.attributes[0].normal_oct), Vec3(0, 0, 1)), 1e-4f);
}

TEST_F(GltfTest, strips_and_fans_keep_the_winding_and_points_are_left_out_with_a_warning) {
    GltfBuilder builder;
    const int positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    for (const int mode : {5, 6, 0}) {
        builder.add_mesh({{"attributes", {{"POSITION", positions}}}, {"mode", mode}});
        builder.add_node({{"mesh", mode == 5 ? 0 : mode == 6 ? 1 : 2}});
    }
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    EXPECT_EQ(in.model->triangle_count, 6u);
    EXPECT_EQ(in.context.warnings().size(), 1u);
    for (const Vec3& p : in.mesh(0).positions) EXPECT_EQ(p.z, 0.0f);
    for (const auto& a : in.mesh(0).attributes) EXPECT_GT(scene::decode_normal(a.normal_oct).z, 0.99f);
}

TEST_F(GltfTest, every_index_type_and_none_give_the_same_triangles) {
    std::vector<std::vector<std::uint32_t>> seen;
    for (const int type : {0, 5121, 5123, 5125}) {
        GltfBuilder builder;
        const int positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
        const int normals = builder.add_positions({0, 0, 1, 0, 0, 1, 0, 0, 1});
        json primitive = {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}};
        const int view = type == 5121   ? builder.add_view<std::uint8_t>({0, 1, 2})
                         : type == 5123 ? builder.add_view<std::uint16_t>({0, 1, 2})
                                        : builder.add_view<std::uint32_t>({0, 1, 2});
        if (type != 0) primitive["indices"] = builder.add_accessor(view, type, "SCALAR", 3);
        builder.add_mesh(primitive);
        builder.add_node({{"mesh", 0}});
        Imported in = import_builder(builder);
        ASSERT_TRUE(in.model) << in.error();
        EXPECT_EQ(in.mesh().indices, (std::vector<std::uint32_t>{0, 1, 2})) << type;
    }
}

TEST_F(GltfTest, interleaved_normalized_and_sparse_accessors_are_read) {
    GltfBuilder builder;
    // Positions of 12 bytes and normalized colours of 4, interleaved every 16.
    std::vector<std::uint8_t> bytes(48);
    const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    for (std::size_t i = 0; i < 3; ++i) {
        std::memcpy(bytes.data() + 16 * i, xyz + 3 * i, 12);
        const std::uint8_t rgba[4] = {255, 0, static_cast<std::uint8_t>(100 * i), 255};
        std::memcpy(bytes.data() + 16 * i + 12, rgba, 4);
    }
    const int view = builder.add_view(bytes, 16);
    const int positions = builder.add_accessor(view, 5126, "VEC3", 3);
    const int colors = builder.add_accessor(view, 5121, "VEC4", 3, true);
    builder.document["accessors"][1]["byteOffset"] = 12;
    // Sparse: vertex 2 moves to (0, 5, 0).
    const int at = builder.add_view<std::uint8_t>({2}), value = builder.add_view<float>({0, 5, 0});
    builder.document["accessors"][0]["sparse"] = {
        {"count", 1}, {"indices", {{"bufferView", at}, {"componentType", 5121}}}, {"values", {{"bufferView", value}}}};
    builder.add_mesh({{"attributes", {{"POSITION", positions}, {"COLOR_0", colors}}}});
    builder.add_node({{"mesh", 0}});
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    EXPECT_EQ(in.mesh().positions[2], Vec3(0, 5, 0));
    EXPECT_EQ(in.mesh().attributes[2].color, 0xFFC800FFu);
}

TEST_F(GltfTest, gpu_instancing_places_the_mesh_many_times) {
    GltfBuilder builder = GltfBuilder::triangle();
    const int translations = builder.add_positions({0, 0, 0, 10, 0, 0, 0, 0, 10});
    builder.document["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    builder.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = translations;
    builder.document["nodes"][0]["translation"] = {0, 7, 0};
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    ASSERT_EQ(in.model->parts.size(), 3u);
    EXPECT_EQ(in.model->parts[1].position, DVec3(10, 7, 0));
    EXPECT_EQ(in.model->parts[1].use_count, 3u);
}

TEST_F(GltfTest, only_the_default_scene_is_drawn) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["nodes"].push_back({{"mesh", 0}, {"translation", {5, 0, 0}}});
    builder.document["scenes"].push_back({{"nodes", {1}}});
    builder.document["scene"] = 1;
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    ASSERT_EQ(in.model->parts.size(), 1u);
    EXPECT_EQ(in.model->parts[0].position, DVec3(5, 0, 0));
}

TEST_F(GltfTest, texture_transforms_are_baked_and_a_texture_of_three_by_five_becomes_a_power_of_two) {
    GltfBuilder builder = GltfBuilder::triangle();
    // The smallest image that OpenImageIO reads without a codec: a 24-bit BMP, 3 x 5.
    const std::uint32_t header[] = {114, 0, 54, 40, 3, 5, 1 | 24 << 16, 0, 60, 2835, 2835, 0, 0};
    std::string text = "BM";
    text.append(reinterpret_cast<const char*>(header), sizeof header);
    text.append(60, '\x80');
    const std::vector<char> bmp(text.begin(), text.end());
    const int image = builder.add_view(bmp);
    const int uvs = builder.add_accessor(builder.add_view<float>({0, 0, 1, 0, 0, 1}), 5126, "VEC2", 3);
    builder.document["images"] = json::array({{{"bufferView", image}}});
    builder.document["samplers"] = json::array({{{"wrapS", 33071}, {"wrapT", 33648}}});
    builder.document["textures"] = json::array({{{"source", 0}, {"sampler", 0}}});
    json info = {{"index", 0}};
    info["extensions"]["KHR_texture_transform"] = {{"offset", {0.5, 0.25}}, {"scale", {2, 4}}};
    builder.document["materials"] = json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", info}}}}});
    builder.document["meshes"][0]["primitives"][0]["material"] = 0;
    builder.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs;
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    EXPECT_EQ(in.mesh().attributes[2].uv, Vec2(0.5f, 4.25f));
    ASSERT_EQ(in.world.textures.size(), 1u);
    EXPECT_EQ(in.world.textures[0].width, 4u);
    EXPECT_EQ(in.world.textures[0].height, 4u);
    EXPECT_EQ(in.world.textures[0].wrap_u, scene::Wrap::clamp);
    EXPECT_EQ(in.world.textures[0].wrap_v, scene::Wrap::mirror);
    for (const std::uint32_t texel : in.world.textures[0].rgba) EXPECT_EQ(texel, 0xFF808080u);
    EXPECT_EQ(in.world.materials.at(0).base_color_texture, 0u);
}

TEST_F(GltfTest, materials_keep_their_factors_and_needless_alpha_is_dropped) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["materials"] =
        json::array({{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0.5, 0.25, 1}}, {"metallicFactor", 0}}},
                      {"alphaMode", "MASK"},
                      {"doubleSided", true},
                      {"emissiveFactor", {0, 1, 0}},
                      {"extensions",
                       {{"KHR_materials_unlit", json::object()},
                        {"KHR_materials_emissive_strength", {{"emissiveStrength", 3}}}}}}});
    builder.document["meshes"][0]["primitives"][0]["material"] = 0;
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    const scene::Material& material = in.world.materials.at(0);
    EXPECT_EQ(material.base_color, Vec4(1, 0.5f, 0.25f, 1));
    EXPECT_EQ(material.emissive, Vec3(0, 3, 0));
    EXPECT_EQ(material.flags, scene::kMaterialDoubleSided | scene::kMaterialUnlit);
}

TEST_F(GltfTest, meshopt_views_are_decoded) {
    GltfBuilder builder;
    const float vertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::vector<std::uint8_t> packed(meshopt_encodeVertexBufferBound(3, 12));
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), vertices, 3, 12));
    const int view = builder.add_view(packed);
    builder.document["bufferViews"][view] = {{"buffer", 1}, {"byteLength", 36}, {"byteStride", 12}};
    builder.document["bufferViews"][view]["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0}, {"byteLength", packed.size()}, {"byteStride", 12}, {"count", 3}, {"mode", "ATTRIBUTES"}};
    builder.document["extensionsRequired"] = {"EXT_meshopt_compression"};
    builder.add_mesh({{"attributes", {{"POSITION", builder.add_accessor(view, 5126, "VEC3", 3)}}}});
    builder.add_node({{"mesh", 0}});
    std::string glb = builder.glb();
    builder.document["buffers"] = json::array({{{"byteLength", builder.binary.size()}}, {{"byteLength", 36}}});
    // glb() writes one buffer; a second without data is added to the text form instead.
    builder.document["buffers"][0]["uri"] = "vertices.bin";
    write_bytes(folder_ / "vertices.bin", builder.binary);
    write_bytes(folder_ / "model.gltf", builder.document.dump());
    Imported in(folder_ / "model.gltf");
    ASSERT_TRUE(in.model) << in.error();
    EXPECT_EQ(in.mesh().positions[1], Vec3(1, 0, 0));
}

TEST_F(GltfTest, optional_extensions_are_warned_about_by_name_and_skins_and_morphs_too) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["extensionsUsed"] = {"EXT_made_up", "KHR_materials_unlit"};
    builder.document["skins"] = json::array({{{"joints", {0}}}});
    builder.document["meshes"][0]["primitives"][0]["targets"] = json::array({{{"POSITION", 0}}});
    Imported in = import_builder(builder);
    ASSERT_TRUE(in.model) << in.error();
    ASSERT_EQ(in.context.warnings().size(), 3u);
    EXPECT_NE(in.context.warnings()[2].find("EXT_made_up"), std::string::npos) << in.context.warnings()[2];
}

TEST_F(GltfTest, a_neighbouring_folder_may_be_named_but_nothing_further_up) {
    std::filesystem::create_directories(folder_ / "models");
    std::filesystem::create_directories(folder_ / "data");
    GltfBuilder builder = GltfBuilder::triangle();
    write_bytes(folder_ / "data/geo metry.bin", builder.binary);
    const auto import_with = [&](const std::string& uri) {
        builder.document["buffers"] = json::array({{{"byteLength", builder.binary.size()}, {"uri", uri}}});
        write_bytes(folder_ / "models/model.gltf", builder.document.dump());
        return Imported(folder_ / "models/model.gltf").error();
    };
    EXPECT_EQ(import_with("../data/geo%20metry.bin"), "no error");
    EXPECT_NE(import_with("../../etc/passwd").find("buffers[0].uri"), std::string::npos);
    EXPECT_NE(import_with("a/../../../x").find("near the model's folder"), std::string::npos);
    EXPECT_NE(import_with("/etc/passwd").find("near the model's folder"), std::string::npos);
    EXPECT_NE(import_with("file:///etc/passwd").find("expected data: or a relative path"), std::string::npos);
    EXPECT_NE(import_with("%2e%2e/%2e%2e/x").find("near the model's folder"), std::string::npos);
}

}  // namespace
}  // namespace ff::test
