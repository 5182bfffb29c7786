// The scenes that come with the repository.

#include <gtest/gtest.h>

#include <filesystem>
#include <glm/geometric.hpp>

#include "tools/cook/scene_toml.h"

namespace ff::cook {
namespace {

namespace fs = std::filesystem;

struct Counts {
    std::size_t triangles = 0, instances = 0;
};

Counts count(const WorldSource& world) {
    Counts counts;
    for (const SourceMesh& mesh : world.meshes) counts.triangles += mesh.geometry.triangle_materials.size();
    for (const Placement& placement : world.placements) counts.instances += placement.kind == PlacementKind::instance;
    return counts;
}

Result<WorldSource> load(const fs::path& path, int scale = 1) {
    CookCache cache;
    CookContext context(cache);
    Result<WorldSource> world = load_scene_toml(path, {.scale = scale}, context);
    EXPECT_TRUE(world) << (world ? "" : world.error().message);
    return world;
}

SourceWalk walk_called(const std::string& name, const WorldSource& world) {
    for (const SourceWalk& walk : world.walks)
        if (walk.name == name) return walk;
    ADD_FAILURE() << "no walk called " << name;
    return {};
}

TEST(SampleWorld, holds_two_million_triangles_and_ten_times_that_at_scale_10) {
    const fs::path path = fs::path(FF_CONTENT_DIR) / "valley.toml";
    SourceWalk street;
    {
        const Result<WorldSource> world = load(path);
        ASSERT_TRUE(world);
        EXPECT_GE(count(*world).triangles, 2'000'000u);
        EXPECT_LE(count(*world).triangles, 3'500'000u);
        EXPECT_GE(count(*world).instances, 10'000u);
        ASSERT_EQ(world->walks.size(), 6u) << "the five that every world has, and the game's cart's";
        street = walk_called("street", *world);
        EXPECT_GE(street.frames.size(), 400u);
    }
    const Result<WorldSource> large = load(path, 10);
    ASSERT_TRUE(large);
    EXPECT_GE(count(*large).triangles, 20'000'000u);
    // The street walk leads along the same way.
    const SourceWalk of_large = walk_called("street", *large);
    ASSERT_EQ(of_large.frames.size(), street.frames.size());
    for (std::size_t f = 0; f < street.frames.size(); ++f)
        ASSERT_LT(glm::distance(of_large.frames[f].position, street.frames[f].position), 0.01) << "frame " << f;
}

class SharedScene : public testing::TestWithParam<const char*> {};

TEST_P(SharedScene, is_read_to_its_horizon) {
    if (!fs::exists(fs::path(FF_SHARED_DIR) / "content/city")) GTEST_SKIP() << "no shared content at " << FF_SHARED_DIR;
    const Result<WorldSource> world = load(fs::path(FF_CONTENT_DIR) / "../tests/content" / GetParam());
    ASSERT_TRUE(world);
    EXPECT_GE(count(*world).triangles, 300'000u);
    EXPECT_GE(count(*world).instances, 1000u);
    EXPECT_EQ(world->walks.size(), 5u);
}

INSTANTIATE_TEST_SUITE_P(All, SharedScene, testing::Values("baltimore.toml", "pyrenees.toml"));

}  // namespace
}  // namespace ff::cook
