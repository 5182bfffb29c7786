// Sources to packs and back.

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "engine/scene/load_world.h"
#include "tests/cook/gltf_builder.h"
#include "tools/cook/cook.h"
#include "tools/cook/image_load.h"

namespace ff::test {
namespace {

// A square of ground with uneven ends, and a wall that stands on it twice; textured by two files beside it.
void write_model(const TemporaryFolder& folder, unsigned char grey = 128) {
    GltfBuilder builder;
    const int ground = builder.add_positions({-50, 0, -50, -50, 0, 50, 60, 0, 50, -50, 0, -50, 60, 0, 50, 50, 0, -50});
    const int wall = builder.add_positions({0, 0, 0, 5, 0, 0, 5, 4, 0, 0, 0, 0, 5, 4, 0, 0, 4, 0});
    const int uvs =
        builder.add_accessor(builder.add_view<float>({0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1}), 5126, "VEC2", 6);
    for (int i = 0; i < 2; ++i) {
        builder.document["images"].push_back({{"uri", i == 0 ? "a.bmp" : "b.bmp"}});
        builder.document["textures"].push_back({{"source", i}});
        builder.document["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
        builder.add_mesh(
            {{"attributes", {{"POSITION", i == 0 ? ground : wall}, {"TEXCOORD_0", uvs}}}, {"material", i}});
        const std::uint32_t header[] = {118, 0, 54, 40, 4, 4, 1 | 24 << 16, 0, 48, 2835, 2835, 0, 0};
        std::string bmp = "BM";
        bmp.append(reinterpret_cast<const char*>(header), sizeof header);
        bmp.append(48, static_cast<char>(i == 0 ? 200 : grey));
        write_bytes(folder / (i == 0 ? "a.bmp" : "b.bmp"), bmp);
    }
    builder.add_node({{"mesh", 0}});
    builder.add_node({{"mesh", 1}});
    builder.add_node({{"mesh", 1}, {"translation", {20, 0, 7}}});
    write_bytes(folder / "model.glb", builder.glb());
}

class CookDriver : public testing::Test {
  protected:
    cook::CookSettings with_cache(int jobs = 0) const { return {.jobs = jobs, .cache_dir = folder_ / "cache"}; }
    std::string pack_bytes(const std::string& name) const {
        const auto bytes = cook::read_file_bytes(folder_ / name);
        return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "";
    }
    TemporaryFolder folder_;
};

TEST_F(CookDriver, a_bare_model_becomes_a_pack_that_loads_with_its_walks_and_spawn) {
    write_model(folder_);
    const auto report = cook::cook(folder_ / "model.glb", folder_ / "w.ffpack", with_cache());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->triangles_instanced, 6u);
    EXPECT_EQ(report->textures, 2u);
    const auto world = scene::load_world(folder_ / "w.ffpack");
    ASSERT_TRUE(world) << world.error().message;
    EXPECT_EQ((*world)->info().name, "model");
    for (const char* walk : {"street", "orbit", "flyover", "turn", "sprint"})
        EXPECT_NE((*world)->find_walk(walk), nullptr) << walk;
    EXPECT_EQ((*world)->statistics().instanced_triangles, 6u);
    const json parsed = json::parse(report->to_json());
    EXPECT_EQ(parsed.at("instanced_triangles"), 6);
    EXPECT_EQ(parsed.at("bytes_out"), std::filesystem::file_size(folder_ / "w.ffpack"));
    EXPECT_GT(parsed.at("bytes_in"), std::filesystem::file_size(folder_ / "model.glb"));
}

TEST_F(CookDriver, same_input_same_bytes_for_any_workers_with_and_without_cache) {
    write_model(folder_);
    ASSERT_TRUE(cook::cook(folder_ / "model.glb", folder_ / "1.ffpack", {.scale = 3, .jobs = 1, .use_cache = false}));
    cook::CookSettings cached = with_cache(2);
    cached.scale = 3;
    for (const char* name : {"2.ffpack", "3.ffpack"})
        ASSERT_TRUE(cook::cook(folder_ / "model.glb", folder_ / name, cached));
    EXPECT_EQ(pack_bytes("1.ffpack"), pack_bytes("2.ffpack"));
    EXPECT_EQ(pack_bytes("1.ffpack"), pack_bytes("3.ffpack"));
    EXPECT_FALSE(pack_bytes("1.ffpack").empty());
}

TEST_F(CookDriver, touching_one_texture_recooks_only_that) {
    write_model(folder_);
    ASSERT_TRUE(cook::cook(folder_ / "model.glb", folder_ / "w.ffpack", with_cache()));
    const std::string before = pack_bytes("w.ffpack");
    write_model(folder_, 60);
    const auto report = cook::cook(folder_ / "model.glb", folder_ / "w.ffpack", with_cache());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->cache_misses, 1u);
    EXPECT_GE(report->cache_hits, 2u);
    EXPECT_NE(pack_bytes("w.ffpack"), before);
}

TEST_F(CookDriver, scale_stores_copies_as_geometry_of_their_own) {
    write_model(folder_);
    const auto once = cook::cook(folder_ / "model.glb", folder_ / "1.ffpack", {.use_cache = false});
    const auto five = cook::cook(folder_ / "model.glb", folder_ / "5.ffpack", {.scale = 5, .use_cache = false});
    ASSERT_TRUE(once && five);
    EXPECT_EQ(five->triangles_stored, 5 * once->triangles_stored);
    EXPECT_EQ(five->triangles_instanced, 5 * once->triangles_instanced);
    EXPECT_FALSE(cook::cook(folder_ / "model.glb", folder_ / "0.ffpack", {.scale = 0}));
}

TEST_F(CookDriver, an_error_leaves_the_old_pack_untouched) {
    write_model(folder_);
    ASSERT_TRUE(cook::cook(folder_ / "model.glb", folder_ / "w.ffpack", with_cache()));
    const std::string before = pack_bytes("w.ffpack");
    const std::string whole = pack_bytes("model.glb");
    write_bytes(folder_ / "model.glb", whole.substr(0, whole.size() / 2));
    const auto broken = cook::cook(folder_ / "model.glb", folder_ / "w.ffpack", with_cache());
    ASSERT_FALSE(broken);
    EXPECT_EQ(broken.error().kind, ErrorKind::bad_input);
    write_bytes(folder_ / "model.glb", whole);
    write_bytes(folder_ / "b.bmp", "this is no image");
    EXPECT_FALSE(cook::cook(folder_ / "model.glb", folder_ / "w.ffpack", with_cache()));
    std::filesystem::remove(folder_ / "b.bmp");
    EXPECT_FALSE(cook::cook(folder_ / "model.glb", folder_ / "w.ffpack", with_cache()));
    EXPECT_EQ(pack_bytes("w.ffpack"), before);
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
        EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << "nothing half-written stays";
}

TEST_F(CookDriver, a_pack_over_its_source_or_in_no_folder_is_refused_before_work_begins) {
    write_model(folder_);
    const std::string before = pack_bytes("model.glb");
    EXPECT_FALSE(cook::cook(folder_ / "model.glb", folder_ / "model.glb", with_cache()));
    EXPECT_EQ(pack_bytes("model.glb"), before);
    EXPECT_FALSE(cook::cook(folder_ / "model.glb", folder_ / "none/w.ffpack", with_cache()));
}

TEST_F(CookDriver, sources_of_unknown_kind_and_models_without_triangles_are_errors) {
    write_bytes(folder_ / "scene.obj", "v 0 0 0");
    const auto unknown = cook::cook(folder_ / "scene.obj", folder_ / "w.ffpack", with_cache());
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find(".toml, .gltf or .glb"), std::string::npos);
    GltfBuilder builder;
    write_bytes(folder_ / "empty.glb", builder.glb());
    EXPECT_FALSE(cook::cook(folder_ / "empty.glb", folder_ / "w.ffpack", with_cache()));
}

class CookSharedContent : public CookDriver {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(content())) GTEST_SKIP() << content() << " is not there";
    }
    static std::filesystem::path content() { return std::filesystem::path(FF_SHARED_DIR) / "content"; }
};

TEST_F(CookSharedContent, real_scenes_cook_and_load) {
    for (const char* file : {"city/rotterdam.glb", "scenes/stk_cornfield_crossing.glb", "scenes/stk_temple.glb",
                             "scenes/fg_oahu.glb", "scenes/torcs_street-1.glb", "scenes/openarena_oa_thor.glb"}) {
        const auto report = cook::cook(content() / file, folder_ / "w.ffpack", with_cache());
        ASSERT_TRUE(report) << report.error().message;
        const auto world = scene::load_world(folder_ / "w.ffpack");
        ASSERT_TRUE(world) << file << ": " << world.error().message;
        EXPECT_EQ((*world)->statistics().instanced_triangles, report->triangles_instanced);
        EXPECT_GT(report->triangles_instanced, 25000u) << file;
    }
}

}  // namespace
}  // namespace ff::test
