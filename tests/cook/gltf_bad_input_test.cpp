// Broken documents: a message with file, place and expectation; never a crash, a hang or absurd memory.

#include <random>

#include "tests/cook/gltf_builder.h"

namespace ff::test {
namespace {

class GltfBadInput : public GltfTest {
  protected:
    // Changes the triangle at one place and expects an error that names the place.
    void expect_error(const std::string& pointer, const json& value, const std::string& place) {
        GltfBuilder builder = GltfBuilder::triangle();
        builder.document[json::json_pointer(pointer)] = value;
        expect_error(builder, place);
    }
    void expect_error(GltfBuilder& builder, const std::string& place) {
        Imported in = import_builder(builder);
        ASSERT_FALSE(in.model) << place;
        EXPECT_EQ(in.model.error().kind, ErrorKind::bad_input);
        EXPECT_NE(in.error().find("model.glb: "), std::string::npos) << in.error();
        EXPECT_NE(in.error().find(place), std::string::npos) << in.error();
        EXPECT_NE(in.error().find("expected"), std::string::npos) << in.error();
        EXPECT_TRUE(in.world.meshes.empty());
        EXPECT_TRUE(in.world.materials.empty());
    }
};

TEST_F(GltfBadInput, indices_out_of_range_are_named_where_they_stand) {
    expect_error("/meshes/0/primitives/0/attributes/POSITION", 17, "meshes[0].primitives[0].attributes.POSITION: 17");
    expect_error("/meshes/0/primitives/0/indices", -1, "meshes[0].primitives[0].indices");
    expect_error("/meshes/0/primitives/0/material", 0, "meshes[0].primitives[0].material");
    expect_error("/nodes/0/mesh", 1, "nodes[0].mesh");
    expect_error("/scenes/0/nodes/0", 99, "scenes[0].nodes[0]");
    expect_error("/scene", 3, "scene: 3");
    expect_error("/accessors/0/bufferView", 1e3, "accessors[0].bufferView");
    expect_error("/bufferViews/0/buffer", 7, "bufferViews[0].buffer");
}

TEST_F(GltfBadInput, vertex_indices_beyond_the_vertices_are_errors) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["accessors"].clear();
    builder.add_accessor(0, 5126, "VEC3", 2);
    builder.add_accessor(1, 5123, "SCALAR", 3);
    expect_error(builder, "meshes[0].primitives[0].indices: element 2");
}

TEST_F(GltfBadInput, accessors_and_views_stay_inside_what_holds_them) {
    expect_error("/accessors/0/count", 4, "accessors[0]: 4 elements");
    expect_error("/accessors/0/count", 4000000000000ll, "accessors[0].count");
    expect_error("/accessors/0/count", 0, "accessors[0].count");
    expect_error("/accessors/0/byteOffset", 18446744073709551615ull, "accessors[0].byteOffset");
    expect_error("/accessors/0/byteOffset", 4, "accessors[0]");
    expect_error("/accessors/0/componentType", 5130, "accessors[0].componentType");
    expect_error("/accessors/0/type", "VEC5", "accessors[0].type");
    expect_error("/bufferViews/0/byteLength", 1000, "bufferViews[0]");
    expect_error("/bufferViews/0/byteOffset", 9007199254740991ll, "bufferViews[0]");
    expect_error("/bufferViews/0/byteStride", 3, "bufferViews[0].byteStride");
    expect_error("/bufferViews/0/byteStride", 6, "bufferViews[0].byteStride");
    expect_error("/bufferViews/0/byteStride", 8, "accessors[0]");
    expect_error("/bufferViews/0/byteStride", 252, "bufferViews[0].byteStride");
}

TEST_F(GltfBadInput, node_graphs_with_loops_or_two_parents_are_errors) {
    expect_error("/nodes/0/children", json::array({0}), "nodes[0]");
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["nodes"] =
        json::array({{{"mesh", 0}}, {{"children", {2}}}, {{"children", {3}}}, {{"children", {1}}}});
    expect_error(builder, "ancestor of itself");
    builder.document["nodes"] = json::array({{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}});
    expect_error(builder, "nodes[1].children[0]");
}

TEST_F(GltfBadInput, nan_and_infinite_positions_are_errors) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        GltfBuilder builder;
        builder.add_mesh({{"attributes", {{"POSITION", builder.add_positions({0, 0, 0, 1, bad, 0, 0, 1, 0})}}}});
        builder.add_node({{"mesh", 0}});
        expect_error(builder, "meshes[0].primitives[0].attributes.POSITION: element 1");
    }
    expect_error("/nodes/0/translation", {1e300, 0, 0}, "nodes[0].translation");
    expect_error("/nodes/0/scale", {1, 2}, "nodes[0].scale");
}

TEST_F(GltfBadInput, required_extensions_that_are_not_read_are_named) {
    expect_error("/extensionsRequired", json::array({"KHR_texture_basisu"}), "KHR_texture_basisu");
}

TEST_F(GltfBadInput, images_that_are_no_images_are_errors) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["images"] = json::array({{{"bufferView", 0}}});
    builder.document["textures"] = json::array({{{"source", 0}}});
    builder.document["materials"] = json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
    expect_error(builder, "images[0]");
    const std::string png = "\x89PNG\r\n\x1a\n and then nothing";
    builder.document["images"][0]["bufferView"] = builder.add_view(std::vector<char>(png.begin(), png.end()));
    expect_error(builder, "images[0]");
    builder.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 5;
    expect_error(builder, "materials[0].pbrMetallicRoughness.baseColorTexture.index");
}

TEST_F(GltfBadInput, absurd_counts_are_refused_before_memory_is_given_out) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["accessors"][0] = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 4000000000u}};
    expect_error(builder, "meshes[0].primitives[0].attributes.POSITION");
    builder = GltfBuilder::triangle();
    builder.document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0}, {"byteLength", 36}, {"byteStride", 256}, {"count", 100000000}, {"mode", "ATTRIBUTES"}};
    expect_error(builder, "EXT_meshopt_compression");
}

TEST_F(GltfBadInput, draco_data_that_is_none_is_an_error) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
    expect_error(builder, "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression");
}

TEST_F(GltfBadInput, deep_nesting_does_not_overflow_the_stack) {
    write_bytes(folder_ / "deep.gltf", std::string(1000000, '['));
    EXPECT_NE(Imported(folder_ / "deep.gltf").error().find("nests deeper"), std::string::npos);
    // A chain of nodes may be long: it is walked without recursion.
    GltfBuilder builder = GltfBuilder::triangle();
    json nodes = json::array();
    for (int i = 0; i < 50000; ++i) nodes.push_back({{"children", {i + 1}}});
    nodes.push_back({{"mesh", 0}});
    builder.document["nodes"] = nodes;
    Imported in = import_builder(builder);
    EXPECT_TRUE(in.model) << in.error();
}

TEST_F(GltfBadInput, a_glb_cut_at_any_byte_is_an_error) {
    GltfBuilder builder = GltfBuilder::triangle();
    const std::string whole = builder.glb();
    for (std::size_t size = 0; size < whole.size(); ++size)
        ASSERT_FALSE(import_glb(whole.substr(0, size)).model) << size;
}

TEST_F(GltfBadInput, random_damage_never_crashes) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["nodes"][0]["translation"] = {1, 2, 3};
    builder.document["materials"] = json::array({{{"alphaMode", "MASK"}, {"alphaCutoff", 0.25}}});
    const std::string whole = builder.glb();
    for (std::uint32_t seed = 0; seed < 2000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::string spoilt = whole;
        for (std::uint32_t n = random() % 4 + 1; n > 0; --n)
            spoilt[random() % spoilt.size()] = static_cast<char>(random());
        const Imported in = import_glb(spoilt);
        if (!in.model) {
            EXPECT_EQ(in.model.error().kind, ErrorKind::bad_input);
        }
    }
}

TEST_F(GltfBadInput, a_missing_file_a_folder_and_an_empty_file_are_errors) {
    EXPECT_NE(Imported(folder_ / "none.glb").error().find("cannot open"), std::string::npos);
    EXPECT_NE(Imported(folder_.path()).error().find("a directory"), std::string::npos);
    EXPECT_NE(import_glb("").error().find("empty"), std::string::npos);
}

}  // namespace
}  // namespace ff::test
