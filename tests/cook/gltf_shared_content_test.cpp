// Real models made by others: all good ones import with the triangles that their README counts; no bad one crashes.

#include <fmt/format.h>

#include <fstream>

#include "tests/cook/gltf_builder.h"

namespace ff::test {
namespace {

namespace fs = std::filesystem;

class GltfSharedContent : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(content())) GTEST_SKIP() << content() << " is not there";
    }
    static fs::path content() { return fs::path(FF_SHARED_DIR) / "content"; }
    static std::vector<fs::path> models_below(const fs::path& folder) {
        std::vector<fs::path> paths;
        for (const auto& entry : fs::recursive_directory_iterator(folder))
            if (entry.path().extension() == ".glb" || entry.path().extension() == ".gltf")
                paths.push_back(entry.path());
        std::sort(paths.begin(), paths.end());
        return paths;
    }
    static std::uint64_t stored_triangles(const Imported& in) {
        std::uint64_t count = 0;
        for (const auto& mesh : in.world.meshes) count += mesh.geometry.triangle_materials.size();
        return count;
    }
};

TEST_F(GltfSharedContent, good_models_have_the_triangles_of_the_readme) {
    struct Expected {
        const char* file;
        std::uint64_t drawn;
    };
    for (const Expected& expected :
         std::initializer_list<Expected>{{"gltf/khronos/DiffuseTransmissionPlant.glb", 69806},
                                         {"gltf/khronos/NegativeScaleTest.glb", 7724},
                                         {"gltf/khronos/TextureSettingsTest.glb", 72},
                                         {"gltf/khronos/Fox.glb", 576},
                                         {"gltf/khronos/VertexColorTest.glb", 36},
                                         {"gltf/cesium/tree-lime-2-0.glb", 919},
                                         {"gltf/cesium/house-3-0.glb", 580},
                                         {"gltf/sketchfab/terrain-low-poly.glb", 3868},
                                         {"gltf/sketchfab/low-poly-tree.glb", 1126},
                                         {"gltf/eztree/flower_white.glb", 788},
                                         {"gltf-compressed/Box_Draco.glb", 12},
                                         {"gltf-compressed/rock1_draco_webp.glb", 1756},
                                         {"gltf-compressed/pmndrs_house1_draco.gltf", 340},
                                         {"gltf-compressed/pmndrs_tree-big_draco.gltf", 556},
                                         {"gltf-compressed/pmndrs_bridge-01_draco.gltf", 3198},
                                         {"gltf-compressed/DenseSphere_draco_quant.glb", 30720},
                                         {"gltf-compressed/pirate_meshopt.glb", 5010},
                                         {"scenes/stk_cornfield_crossing.glb", 330434},
                                         {"scenes/stk_temple.glb", 206452},
                                         {"scenes/torcs_street-1.glb", 25508},
                                         {"scenes/openarena_oa_thor.glb", 57731},
                                         {"scenes/fg_oahu.glb", 163662},
                                         {"trees/stklib_palmTree_a_lod0.glb", 843},
                                         {"city/rotterdam.glb", 130449}}) {
        const Imported in(content() / expected.file);
        ASSERT_TRUE(in.model) << in.error();
        EXPECT_EQ(in.model->triangle_count, expected.drawn) << expected.file;
    }
}

TEST_F(GltfSharedContent, whole_folders_have_the_triangles_of_the_readme) {
    const auto triangles_below = [&](const char* folder) {
        std::uint64_t sum = 0;
        for (const fs::path& path : models_below(content() / folder)) {
            const Imported in(path);
            EXPECT_TRUE(in.model) << in.error();
            if (in.model) sum += in.model->triangle_count;
        }
        return sum;
    };
    EXPECT_EQ(triangles_below("gltf/kaykit_city"), 19845u);
    EXPECT_EQ(triangles_below("gltf/kenney_city"), 4208u);
    EXPECT_GT(triangles_below("gltf-edge"), 0u);
}

TEST_F(GltfSharedContent, the_draco_compressed_temple_equals_the_plain_one) {
    const Imported plain(content() / "scenes/stk_temple.glb"),
        packed(content() / "gltf-compressed/stk_temple_draco.glb");
    ASSERT_TRUE(plain.model) << plain.error();
    ASSERT_TRUE(packed.model) << packed.error();
    EXPECT_EQ(stored_triangles(plain), stored_triangles(packed));
    ASSERT_EQ(plain.model->parts.size(), packed.model->parts.size());
    EXPECT_EQ(plain.world.textures.size(), packed.world.textures.size());
    EXPECT_EQ(plain.world.materials.size(), packed.world.materials.size());
    const DVec3 extent = plain.model->bounds.extent();
    for (int i = 0; i < 3; ++i) {  // Draco quantizes positions: 11 bits or better
        EXPECT_NEAR(plain.model->bounds.low[i], packed.model->bounds.low[i], extent[i] / 1000.0);
        EXPECT_NEAR(plain.model->bounds.high[i], packed.model->bounds.high[i], extent[i] / 1000.0);
    }
    for (std::size_t i = 0; i < plain.model->parts.size(); ++i)
        EXPECT_EQ(plain.model->parts[i].position, packed.model->parts[i].position);
    // The surface of every mesh is the same, whatever order Draco gave its triangles.
    for (std::size_t m = 0; m < plain.world.meshes.size(); ++m) {
        const auto area = [](const scene::MeshSource& mesh) {
            double sum = 0;
            for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
                const Vec3 &a = mesh.positions[mesh.indices[t]], &b = mesh.positions[mesh.indices[t + 1]],
                           &c = mesh.positions[mesh.indices[t + 2]];
                sum += glm::length(glm::cross(DVec3(b - a), DVec3(c - a))) / 2;
            }
            return sum;
        };
        const double expected = area(plain.mesh(m));
        EXPECT_NEAR(area(packed.mesh(m)), expected, expected * 0.01 + 1e-6) << plain.world.meshes[m].name;
    }
}

TEST_F(GltfSharedContent, no_malformed_model_crashes_and_valid_ones_import) {
    for (const fs::path& path : models_below(content() / "gltf-bad")) {
        const Imported in(path);
        if (!in.model) {
            EXPECT_EQ(in.model.error().kind, ErrorKind::bad_input);
        }
        std::ifstream report_file(path.string() + ".report.json");
        const json report = json::parse(report_file);
        if (path.stem().string().starts_with("valid") && report.at("issues").at("numErrors") == 0) {
            EXPECT_TRUE(in.model) << in.error();
        }
    }
}

}  // namespace
}  // namespace ff::test
