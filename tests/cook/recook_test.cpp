// What a second cook takes from the cache, and what it must not.

#include <gtest/gtest.h>

#include <fmt/core.h>

#include <cmath>

#include "engine/scene/load_world.h"
#include "tests/cook/gltf_builder.h"
#include "tools/cook/cook.h"
#include "tools/cook/image_load.h"

namespace ff::test {
namespace {

// 4 x 4 texels of one grey.
std::string picture(unsigned char grey) {
    const std::uint32_t header[] = {118, 0, 54, 40, 4, 4, 1 | 24 << 16, 0, 48, 2835, 2835, 0, 0};
    std::string bmp = "BM";
    bmp.append(reinterpret_cast<const char*>(header), sizeof header);
    return bmp.append(48, static_cast<char>(grey));
}

// 33 x 33 heights of a dome, 10 m apart.
std::string dome(double height_m) {
    std::string text = "ncols 33\nnrows 33\nxllcorner 0\nyllcorner 0\ncellsize 10\n";
    for (int z = 0; z < 33; ++z)
        for (int x = 0; x < 33; ++x) {
            const double r2 = ((x - 16) * (x - 16) + (z - 16) * (z - 16)) / 512.0;
            text += fmt::format("{:.3f}{}", height_m * (1.0 - r2), x == 32 ? '\n' : ' ');
        }
    return text;
}

constexpr const char* kScene =
    "format = 1\n[terrain]\nheightmap = \"dome.asc\"\ntexture = \"grass.bmp\"\n"
    "[town]\nsize_m = 300\ndowntown_m = 100\n"
    "[[scatter]]\nfile = \"tree.glb\"\ndensity_per_km2 = 2000\narea_m = [-150, -150, 150, 150]\n";

// Nothing but made by rule.
constexpr const char* kValley =
    "format = 1\n[terrain]\ngenerator = \"valley\"\nsize_m = [4000, 4000]\nspacing_m = 40\nfloor_width_m = 2500\n"
    "water_m = -4\nnatural_colors = true\ntexture = \"grass.bmp\"\n[town]\nsize_m = 300\ndowntown_m = 100\n";

class Recook : public testing::Test {
  protected:
    void SetUp() override {
        write_bytes(folder_ / "scene.toml", kScene);
        write_bytes(folder_ / "grass.bmp", picture(90));
        write_bytes(folder_ / "dome.asc", dome(12.0));
        write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    }
    cook::CookReport cook_it(cook::CookSettings settings = {}) {
        settings.cache_dir = folder_ / "cache";
        const auto report = cook::cook(folder_ / "scene.toml", folder_ / "w.ffpack", settings);
        EXPECT_TRUE(report) << (report ? "" : report.error().message);
        return report ? *report : cook::CookReport{};
    }
    std::string pack_bytes() const {
        const auto bytes = cook::read_file_bytes(folder_ / "w.ffpack");
        return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "";
    }
    scene::Walk street() const {
        const auto world = scene::load_world(folder_ / "w.ffpack");
        const scene::Walk* walk = world ? (*world)->find_walk("street") : nullptr;
        EXPECT_NE(walk, nullptr);
        return walk ? *walk : scene::Walk{};
    }
    // The same world without a cache has the same bytes.
    void expect_right_bytes() {
        const std::string cached = pack_bytes();
        EXPECT_TRUE(cook::cook(folder_ / "scene.toml", folder_ / "w.ffpack", {.use_cache = false}));
        EXPECT_FALSE(cached.empty());
        EXPECT_EQ(cached, pack_bytes());
    }
    TemporaryFolder folder_;
};

TEST_F(Recook, of_an_untouched_scene_makes_nothing_and_gives_the_same_bytes) {
    for (const char* scene : {kScene, kValley}) {
        write_bytes(folder_ / "scene.toml", scene);
        cook_it({.jobs = 1});
        const std::string before = pack_bytes();
        const cook::CookReport again = cook_it({.jobs = 2});
        EXPECT_EQ(again.cache_misses, 0u);
        EXPECT_EQ(before, pack_bytes());
        expect_right_bytes();
    }
}

TEST_F(Recook, after_a_touched_texture_decodes_that_alone_and_leaves_the_walks_as_they_were) {
    cook_it();
    const std::string before = pack_bytes();
    const scene::Walk walk = street();
    write_bytes(folder_ / "grass.bmp", picture(200));
    EXPECT_EQ(cook_it().cache_misses, 1u);
    EXPECT_NE(before, pack_bytes());
    EXPECT_EQ(street().frames.size(), walk.frames.size());
    EXPECT_EQ(street().frames[40].position, walk.frames[40].position);
    expect_right_bytes();
}

TEST_F(Recook, after_a_touched_heightmap_walks_on_the_new_ground) {
    cook_it();
    const scene::Walk walk = street();
    write_bytes(folder_ / "dome.asc", dome(24.0));
    EXPECT_GE(cook_it().cache_misses, 4u) << "at least its errors, the walks, the cells and some cell's mesh";
    EXPECT_GT(std::abs(street().frames[40].position.y - walk.frames[40].position.y), 1.0);
    expect_right_bytes();
}

TEST_F(Recook, after_a_moved_spawn_point_walks_elsewhere) {
    cook_it();
    const scene::Walk walk = street();
    write_bytes(folder_ / "scene.toml", std::string(kScene) + "[spawn]\nposition_m = [60, 90]\n");
    cook_it();
    EXPECT_NE(street().frames[0].position, walk.frames[0].position);
    expect_right_bytes();
}

TEST_F(Recook, after_a_touched_model_prepares_that_alone_anew) {
    cook_it();
    GltfBuilder taller = GltfBuilder::triangle();
    taller.document["nodes"][0]["scale"] = {1, 3, 1};
    GltfBuilder wider = GltfBuilder::triangle();
    const float width = 2.0f;
    std::memcpy(wider.binary.data() + 12, &width, sizeof width);
    write_bytes(folder_ / "tree.glb", taller.glb());
    EXPECT_LE(cook_it().cache_misses, 3u) << "walks, cells and heights: the mesh is the same, it only stands otherwise";
    expect_right_bytes();
    write_bytes(folder_ / "tree.glb", wider.glb());
    EXPECT_LE(cook_it().cache_misses, 4u) << "those and the tree";
    expect_right_bytes();
}

TEST_F(Recook, with_entries_cut_or_spoilt_makes_them_anew) {
    cook_it();
    const std::string before = pack_bytes();
    int spoilt = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "cache"))
        if (entry.is_regular_file() && ++spoilt % 2 == 0)
            std::filesystem::resize_file(entry.path(), std::filesystem::file_size(entry.path()) - 1);
    EXPECT_EQ(cook_it().cache_misses, std::uint64_t(spoilt / 2));
    EXPECT_EQ(before, pack_bytes());
}

}  // namespace
}  // namespace ff::test
