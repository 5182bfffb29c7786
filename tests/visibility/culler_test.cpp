#include "engine/visibility/culler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/worlds.h"

namespace ff::visibility {
namespace {

DBox3 random_box(test::Random& random, const WorldPos& middle, double spread) {
    const DVec3 center =
        middle + DVec3(random.in(-spread, spread), random.in(-spread, spread), random.in(-spread, spread));
    const DVec3 half(random.in(0.0, 0.1 * spread), random.in(0.0, 0.1 * spread), random.in(0.0, 0.1 * spread));
    DBox3 box;
    box.add(center - half);
    box.add(center + half);
    return box;
}

TEST(CullBoxes, never_culls_what_the_frustum_touches_in_double_and_keeps_little_else) {
    int outside_in_double = 0, kept_in_vain = 0;
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        test::Random random(seed);
        // From millimetres around the viewer to a thousand kilometres from the origin.
        const double spread = std::pow(10.0, random.in(-1.0, 4.0));
        const WorldPos middle(random.in(-1e6, 1e6), random.in(-1e3, 1e3), random.in(-1e6, 1e6));
        BoxArray boxes;
        std::vector<DBox3> exact;
        for (int i = 0; i < 61; ++i) {
            exact.push_back(random_box(random, middle, spread));
            boxes.add(exact.back(), middle);
        }
        boxes.finish();
        DBox3 around;
        around.add(middle - DVec3(spread));
        around.add(middle + DVec3(spread));
        const PinholeView view = make_view(test::random_camera(random, around), 640, 480);
        const Frustum frustum = make_frustum(view);
        std::vector<Overlap> overlaps(exact.size() + kCullPadding);
        cull_boxes(frustum, boxes, middle, 0, exact.size(), overlaps);
        for (std::size_t i = 0; i < exact.size(); ++i) {
            const bool outside = is_outside(frustum, exact[i]);
            if (!outside) {
                EXPECT_NE(overlaps[i], Overlap::outside) << "box " << i;
            } else {
                EXPECT_NE(overlaps[i], Overlap::inside) << "box " << i;
                ++outside_in_double;
                kept_in_vain += overlaps[i] != Overlap::outside;
            }
        }
    }
    EXPECT_LT(kept_in_vain, outside_in_double / 1000 + 3);
}

TEST(CullBoxes, a_box_is_inside_only_if_all_its_corners_are) {
    test::Random random(3);
    const PinholeView view = make_view({.yaw = 0.3}, 640, 480);
    const Frustum frustum = make_frustum(view);
    BoxArray boxes;
    std::vector<DBox3> exact;
    for (int i = 0; i < 500; ++i) {
        exact.push_back(random_box(random, {0, 0, -50}, 60.0));
        boxes.add(exact.back(), WorldPos(0.0));
    }
    boxes.finish();
    std::vector<Overlap> overlaps(exact.size() + kCullPadding);
    cull_boxes(frustum, boxes, WorldPos(0.0), 0, exact.size(), overlaps);
    int inside = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        if (overlaps[i] != Overlap::inside) continue;
        ++inside;
        for (int corner = 0; corner < 8; ++corner) {
            DBox3 point;
            point.add({corner & 1 ? exact[i].low.x : exact[i].high.x, corner & 2 ? exact[i].low.y : exact[i].high.y,
                       corner & 4 ? exact[i].low.z : exact[i].high.z});
            EXPECT_FALSE(is_outside(frustum, point));
        }
    }
    EXPECT_GT(inside, 10);
}

TEST(CullBoxes, an_empty_box_is_outside) {
    BoxArray boxes;
    boxes.add(DBox3{}, WorldPos(0.0));
    boxes.finish();
    std::vector<Overlap> overlaps(1 + kCullPadding);
    cull_boxes(make_frustum(make_view({}, 64, 64)), boxes, WorldPos(0.0), 0, 1, overlaps);
    EXPECT_EQ(overlaps[0], Overlap::outside);
}

/// Instances that double says may be seen, of cells nearer than the limit.
std::vector<std::uint32_t> expected_instances(const scene::StaticScene& scene, const PinholeView& view, double limit) {
    const Frustum frustum = make_frustum(view);
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const scene::Instance& instance = scene.instances[i];
        if (distance_to(scene.cells[instance.cell].bounds, view.position) < limit &&
            !is_outside(frustum, instance.bounds))
            ids.push_back(i);
    }
    return ids;
}

TEST(Culler, finds_the_instances_that_a_test_of_each_in_double_finds) {
    for (const WorldPos& origin : {WorldPos(0.0), WorldPos(1e6, 0.0, -1e6)}) {
        const scene::SceneData world = test::make_forest({.trees = 500}, {.origin = origin});
        const scene::StaticScene scene = world.view();
        const Culler culler(scene);
        test::Random random(11);
        VisibleSet set;
        for (int i = 0; i < 50; ++i) {
            SCOPED_TRACE(i);
            const PinholeView view = make_view(test::random_camera(random, scene.bounds), 320, 240);
            const double limit = i % 2 ? 40.0 : std::numeric_limits<double>::infinity();
            culler.cull(view, {}, set, limit);
            std::vector<std::uint32_t> found = set.instances;
            std::sort(found.begin(), found.end());
            EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end());
            const auto expected = expected_instances(scene, view, limit);
            EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));
            EXPECT_LE(found.size(), expected.size() + 2);
        }
    }
}

TEST(Culler, gives_cells_front_to_back) {
    const scene::SceneData world = test::make_city({.cells = 8});
    const scene::StaticScene scene = world.view();
    const Culler culler(scene);
    const PinholeView view = make_view({.position = {1, 2, 3}}, 320, 240);
    VisibleSet set;
    culler.cull(view, {}, set);
    ASSERT_GT(set.cells.size(), 3u);
    EXPECT_LT(set.cells.size(), scene.cells.size());
    for (std::size_t i = 1; i < set.cells.size(); ++i)
        EXPECT_LE(distance_to(scene.cells[set.cells[i - 1]].bounds, view.position),
                  distance_to(scene.cells[set.cells[i]].bounds, view.position));
}

TEST(Culler, keeps_dynamic_instances_at_any_distance) {
    const scene::SceneData world = test::make_city();
    const scene::StaticScene scene = world.view();
    std::vector<scene::Instance> dynamic(2, scene.instances[0]);
    for (int i = 0; i < 2; ++i) {
        dynamic[i].bounds = {};
        dynamic[i].bounds.add(DVec3(-1, -1, i == 0 ? -5000.0 : 5000.0));
        dynamic[i].bounds.add(DVec3(1, 1, i == 0 ? -4990.0 : 5010.0));
    }
    VisibleSet set;
    Culler(scene).cull(make_view({}, 320, 240), dynamic, set, 0.0);
    EXPECT_EQ(set.instances, std::vector<std::uint32_t>{std::uint32_t(scene.instances.size())});
}

TEST(Culler, an_empty_world_has_nothing_to_see) {
    const scene::SceneData world = test::make_empty_world();
    const scene::StaticScene scene = world.view();
    VisibleSet set;
    Culler(scene).cull(make_view({}, 320, 240), {}, set);
    EXPECT_TRUE(set.instances.empty());
    EXPECT_TRUE(set.cells.empty());
}

}  // namespace
}  // namespace ff::visibility
