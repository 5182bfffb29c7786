// What stands on what, in scenes without terrain: the ground is the topmost upward-facing surface of the static models.

#include <fmt/core.h>

#include <algorithm>

#include "tests/cook/gltf_builder.h"
#include "tools/cook/scene_toml.h"

namespace ff::test {
namespace {

using cook::Placement;
using cook::PlacementKind;
using cook::WorldSource;

// A slope of 200 x 200 m that rises by a tenth towards +x, seen from above; y = x / 10.
GltfBuilder slope() {
    GltfBuilder builder;
    builder.add_mesh({{"attributes",
                       {{"POSITION", builder.add_positions({-100, -10, -100, -100, -10, 100, 100, 10, 100,  //
                                                            -100, -10, -100, 100, 10, 100, 100, 10, -100})}}}});
    builder.add_node({{"mesh", 0}});
    return builder;
}

// A table top of 4 x 4 m at y = 1, with its underside at 0.5.
GltfBuilder table() {
    GltfBuilder builder;
    builder.add_mesh({{"attributes", {{"POSITION", builder.add_positions({-2, 1,   -2, -2, 1,   2, 2,  1,   2,   //
                                                                          -2, 1,   -2, 2,  1,   2, 2,  1,   -2,  //
                                                                          -2, 0.5, -2, 2,  0.5, 2, -2, 0.5, 2})}}}});
    builder.add_node({{"mesh", 0}});
    return builder;
}

class SceneGround : public testing::Test {
  protected:
    void SetUp() override {
        GltfBuilder ground = slope(), thing = table();
        write_bytes(folder_ / "slope.glb", ground.glb());
        write_bytes(folder_ / "table.glb", thing.glb());
        write_bytes(folder_ / "cart.glb", thing.glb());
        write_bytes(folder_ / "tree.glb", GltfBuilder::triangle().glb());
    }
    WorldSource load(const std::string& models) {
        write_bytes(folder_ / "scene.toml", "format = 1\n" + models);
        cook::CookCache cache;
        cook::CookContext context(cache);
        Result<WorldSource> world = cook::load_scene_toml(folder_ / "scene.toml", {}, context);
        EXPECT_TRUE(world) << (world ? "" : world.error().message);
        return world ? std::move(*world) : WorldSource{};
    }
    static std::string model(const char* file, const char* position, const char* more = "") {
        return fmt::format("[[model]]\nfile = \"{}.glb\"\nposition_m = {}\n{}", file, position, more);
    }
    // Heights of what stands at (x, z), in the order placed.
    static std::vector<double> heights_at(const WorldSource& world, double x, double z) {
        std::vector<double> heights;
        for (const Placement& placement : world.placements)
            if (placement.position.x == x && placement.position.z == z) heights.push_back(placement.position.y);
        return heights;
    }
    TemporaryFolder folder_;
};

TEST_F(SceneGround, models_without_a_height_stand_on_other_models_wherever_they_are_written) {
    const std::string ground = model("slope", "[0, 5, 0]"), thing = model("table", "[20, 30]");
    for (const std::string& text : {ground + thing, thing + ground}) {
        const WorldSource world = load(text);
        ASSERT_EQ(world.placements.size(), 2u);
        const std::vector<double> heights = heights_at(world, 20, 30);
        ASSERT_EQ(heights.size(), 1u);
        EXPECT_NEAR(heights[0], 5.0 + 2.0, 1e-5);
    }
}

TEST_F(SceneGround, models_stack_on_the_topmost_surface_that_faces_up) {
    const WorldSource world = load(model("slope", "[0, 0, 0]") + model("table", "[50, 0]") + model("table", "[50, 0]") +
                                   model("table", "[50, 0]"));
    const std::vector<double> heights = heights_at(world, 50, 0);
    ASSERT_EQ(heights.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(heights[i], 5.0 + double(i), 1e-5) << i;
}

TEST_F(SceneGround, a_model_beside_all_others_stands_at_zero) {
    EXPECT_EQ(heights_at(load(model("slope", "[0, 7, 0]") + model("table", "[300, 0]")), 300, 0),
              std::vector<double>{0.0});
}

TEST_F(SceneGround, things_that_move_stand_on_the_ground_but_are_none) {
    const WorldSource world =
        load(model("cart", "[40, 0]", "dynamic = true\n") + model("table", "[40, 0]") + model("slope", "[0, 0, 0]"));
    const std::vector<double> heights = heights_at(world, 40, 0);
    ASSERT_EQ(heights.size(), 2u);
    EXPECT_NEAR(heights[0], 4.0, 1e-5) << "the table stands on the slope";
    EXPECT_NEAR(heights[1], 5.0, 1e-5) << "the cart on the table";
}

TEST_F(SceneGround, scattered_things_stand_on_models_and_not_on_each_other) {
    const std::string scatter =
        "[[scatter]]\nfile = \"tree.glb\"\ndensity_per_km2 = 20000\narea_m = [-150, -150, 150, 150]\n";
    const WorldSource world = load(model("slope", "[0, 0, 0]") + model("table", "[0, 0]") + scatter + scatter);
    std::size_t trees = 0;
    for (const Placement& placement : world.placements) {
        if (placement.kind != PlacementKind::instance) continue;
        ++trees;
        ASSERT_NEAR(placement.position.y, placement.position.x / 10, 1e-4);
        ASSERT_LE(std::max(std::abs(placement.position.x), std::abs(placement.position.z)), 100.0);
        ASSERT_GT(std::max(std::abs(placement.position.x), std::abs(placement.position.z)), 3.4) << "in the table";
    }
    EXPECT_NEAR(double(trees), 2 * 20000 * 0.04, 120);
    const WorldSource steep = load(model("slope", "[0, 0, 0]") + scatter + "slope_max_deg = 5\n");
    EXPECT_EQ(steep.placements.size(), 1u) << "the slope has 5.7 degrees";
}

TEST_F(SceneGround, the_player_and_walks_by_points_stand_on_models) {
    const WorldSource world =
        load(model("slope", "[0, 0, 0]") + "[[scatter]]\nfile = \"tree.glb\"\ndensity_per_km2 = 1e5\n" +
             "area_m = [-100, -100, 100, 100]\n[spawn]\nposition_m = [30, 10]\n" +
             "[[walk]]\nname = \"up\"\npoints_m = [[0, 0], [60, 0]]\nspeed_m_s = 3\n");
    EXPECT_NEAR(world.spawn_position.y, 3.0, 1e-5);
    ASSERT_FALSE(world.walks.empty());
    EXPECT_EQ(world.walks[0].name, "up");
    for (const cook::WalkFrame& frame : world.walks[0].frames)
        ASSERT_NEAR(frame.position.y, frame.position.x / 10 + 1.7, 1e-4);
}

}  // namespace
}  // namespace ff::test
