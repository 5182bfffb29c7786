// Broken sources and packs through the tool: a message that names the file, exit code 3, and the old pack untouched.
// The libraries' own tests go through every byte and every field (gltf_bad_input_test, pack_test, pack_world_test).

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "engine/assets/pack_format.h"
#include "tests/cook/gltf_document.h"
#include "tests/e2e/run_process.h"

namespace ff::test {
namespace {

struct Broken {
    const char* name;
    std::function<std::string()> glb;
    const char* place;  ///< that the message names
};

std::string changed(const std::function<void(GltfBuilder&)>& change) {
    GltfBuilder builder = GltfBuilder::triangle();
    change(builder);
    return builder.glb();
}

std::string with_positions(float bad) {
    GltfBuilder builder;
    builder.add_mesh({{"attributes", {{"POSITION", builder.add_positions({0, 0, 0, 1, bad, 0, 0, 1, 0})}}}});
    builder.add_node({{"mesh", 0}});
    return builder.glb();
}

const std::vector<Broken>& broken_models() {
    static const std::vector<Broken> models{
        {"truncated",
         [] {
             const std::string whole = GltfBuilder::triangle().glb();
             return whole.substr(0, whole.size() - 20);
         },
         "truncated.glb"},
        {"looping",
         [] {
             return changed([](GltfBuilder& b) {
                 b.document["nodes"] = json::array({{{"children", {1}}}, {{"children", {2}}}, {{"children", {1}}}});
             });
         },
         "nodes["},
        {"out_of_range",
         [] { return changed([](GltfBuilder& b) { b.document["meshes"][0]["primitives"][0]["indices"] = 17; }); },
         "meshes[0].primitives[0].indices"},
        {"vertex_out_of_range", [] { return changed([](GltfBuilder& b) { b.document["accessors"][0]["count"] = 2; }); },
         "meshes[0].primitives[0].indices: element 2"},
        {"nan", [] { return with_positions(std::numeric_limits<float>::quiet_NaN()); }, "POSITION: element 1"},
        {"infinite", [] { return with_positions(std::numeric_limits<float>::infinity()); }, "POSITION: element 1"},
        {"absurd",
         [] {
             return changed([](GltfBuilder& b) {
                 b.document["accessors"][0] = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 4000000000u}};
             });
         },
         "POSITION"},
        {"picture",
         [] {
             return changed([](GltfBuilder& b) {
                 b.document["images"] = json::array({{{"bufferView", 0}}});
                 b.document["textures"] = json::array({{{"source", 0}}});
                 b.document["materials"] =
                     json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
             });
         },
         "images[0]"},
    };
    return models;
}

void expect_refused(const ProcessResult& result, const std::string& named) {
    EXPECT_EQ(result.exit_code, 3) << result.err;
    EXPECT_NE(result.err.find(named), std::string::npos) << named << " in: " << result.err;
    EXPECT_EQ(result.out, "");
}

TEST(BadInput, broken_models_are_refused_and_the_old_pack_stays) {
    const auto pack = scratch() / "old.ffpack";
    write_file(pack, "the old pack");
    for (const Broken& broken : broken_models()) {
        SCOPED_TRACE(broken.name);
        const auto model = scratch() / (std::string(broken.name) + ".glb");
        write_file(model, broken.glb());
        const ProcessResult result = run_ff("cook " + model.string() + " -o " + pack.string());
        expect_refused(result, model.filename().string());
        EXPECT_NE(result.err.find(broken.place), std::string::npos) << result.err;
        EXPECT_EQ(read_file(pack), "the old pack");
    }
}

TEST(BadInput, broken_files_that_a_scene_names_are_refused) {
    const auto folder = scratch() / "scene";
    std::filesystem::create_directories(folder);
    write_file(folder / "garbage", "neither a picture nor a map nor a model");
    write_file(folder / "garbage.glb", "neither a picture nor a map nor a model");
    write_file(folder / "garbage.walk.json", "{\"format\": 1, \"frames\": [");
    write_file(folder / "tree.glb", GltfBuilder::triangle().glb());
    const std::string tree = "[[model]]\nfile = \"tree.glb\"\n";
    const std::pair<const char*, std::string> scenes[] = {
        {"garbage", "[terrain]\nheightmap = \"garbage\"\n"},
        {"garbage", "[[buildings]]\nfootprints = \"garbage\"\n"},
        {"garbage", tree + "[sky]\npanorama = \"garbage\"\n"},
        {"garbage.glb", "[[model]]\nfile = \"garbage.glb\"\n"},
        {"garbage.walk.json", tree + "[[walk]]\nname = \"w\"\nfile = \"garbage.walk.json\"\n"},
        {"position_m", tree + "position_m = [nan, 0]\n"},
        {"density_per_km2",
         "[[scatter]]\nfile = \"tree.glb\"\ndensity_per_km2 = 1e9\narea_m = [-900, -900, 900, 900]\n"},
    };
    for (const auto& [named, text] : scenes) {
        SCOPED_TRACE(text);
        write_file(folder / "scene.toml", "format = 1\n" + text);
        expect_refused(run_ff("cook " + (folder / "scene.toml").string() + " -o " + (folder / "w.ffpack").string()),
                       named);
        EXPECT_FALSE(std::filesystem::exists(folder / "w.ffpack"));
    }
}

TEST(BadInput, packs_of_an_older_version_cut_or_with_a_bit_flipped_are_refused) {
    const std::string pack = read_file(hamlet_pack());
    const auto path = scratch() / "spoilt.ffpack";
    const auto expect_no_pack = [&](const std::string& bytes) {
        write_file(path, bytes);
        expect_refused(run_ff("info " + path.string()), "spoilt.ffpack");
    };
    std::string older = pack;
    const std::uint32_t version = assets::kPackVersion - 1;
    std::memcpy(older.data() + offsetof(assets::PackHeader, version), &version, sizeof version);
    write_file(path, older);
    expect_refused(run_ff("info " + path.string()), "cook the world again");
    for (const std::size_t size :
         {std::size_t(0), std::size_t(7), sizeof(assets::PackHeader), pack.size() / 2, pack.size() - 1}) {
        SCOPED_TRACE(size);
        expect_no_pack(pack.substr(0, size));
    }
    for (std::size_t i = 0; i < 8; ++i) {
        const std::size_t at = i * (pack.size() - 1) / 7;
        SCOPED_TRACE(at);
        std::string flipped = pack;
        flipped[at] = char(flipped[at] ^ 0x20);
        expect_no_pack(flipped);
    }
}

}  // namespace
}  // namespace ff::test
