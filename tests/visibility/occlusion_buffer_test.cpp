#include "engine/visibility/occlusion_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/worlds.h"

namespace ff::visibility {
namespace {

constexpr float kNear = 0.02f;
constexpr int kWidth = 101, kHeight = 67;  // neither is a multiple of a block

/// Reversed depths of a wall that fills the view, `distance_m` away along the view axis.
std::vector<float> wall(float distance_m) {
    return std::vector<float>(std::size_t(kWidth) * kHeight, kNear / distance_m);
}

DBox3 box_at(const DVec3& center, double half) {
    DBox3 box;
    box.add(center - DVec3(half));
    box.add(center + DVec3(half));
    return box;
}

TEST(OcclusionBuffer, a_box_behind_a_wall_is_hidden_and_one_before_it_is_not) {
    const WorldPos eye(1e6, 2.0, -1e6);
    OcclusionBuffer buffer;
    EXPECT_FALSE(buffer.is_hidden(box_at({0, 0, -20}, 1.0))) << "before anything was built";
    buffer.build(make_view({.position = eye}, kWidth, kHeight), wall(10.0f), kNear);
    EXPECT_TRUE(buffer.is_hidden(box_at(eye + DVec3(0, 0, -20), 1.0)));
    EXPECT_TRUE(buffer.is_hidden(box_at(eye + DVec3(0, 0, -2000), 1000.0))) << "far wider than the image";
    EXPECT_FALSE(buffer.is_hidden(box_at(eye + DVec3(0, 0, -5), 1.0)));
    EXPECT_FALSE(buffer.is_hidden(box_at(eye + DVec3(0, 0, -10.5), 1.0))) << "cut by the wall";
    EXPECT_FALSE(buffer.is_hidden(box_at(eye, 50.0))) << "around the viewer";
    EXPECT_FALSE(buffer.is_hidden(DBox3{}));
}

TEST(OcclusionBuffer, one_pixel_without_a_wall_shows_every_box_that_it_may_touch) {
    const PinholeView view = make_view({}, kWidth, kHeight);
    OcclusionBuffer buffer;
    for (const int x : {0, 3, 4, 50, kWidth - 1}) {
        for (const int y : {0, 7, 33, kHeight - 1}) {
            std::vector<float> depth = wall(10.0f);
            depth[std::size_t(y) * kWidth + std::size_t(x)] = 0.0f;
            buffer.build(view, depth, kNear);
            const DVec3 there = 30.0 * DVec3(view.direction(x, y));
            EXPECT_FALSE(buffer.is_hidden(box_at(there, 1e-3))) << x << ", " << y;
            EXPECT_FALSE(buffer.is_hidden(box_at(there, 5.0))) << x << ", " << y;
        }
    }
}

TEST(OcclusionBuffer, never_hides_a_box_that_some_pixel_shows_before_what_was_drawn) {
    test::Random random(4);
    OcclusionBuffer buffer;
    int hidden = 0, shown = 0;
    for (int round = 0; round < 200; ++round) {
        SCOPED_TRACE(round);
        DBox3 world;
        world.add(DVec3(-100.0));
        world.add(DVec3(100.0));
        const PinholeView view = make_view(test::random_camera(random, world), kWidth, kHeight);
        // Columns of walls, some without.
        std::vector<float> depth(std::size_t(kWidth) * kHeight);
        const double share = round % 2 ? 1.0 : 0.9;
        for (int x = 0; x < kWidth; x += 10) {
            const auto d = float(random.unit() < share ? kNear / random.in(5.0, 100.0) : 0.0);
            for (int y = 0; y < kHeight; ++y)
                std::fill_n(&depth[std::size_t(y) * kWidth + std::size_t(x)], std::min(10, kWidth - x), d);
        }
        buffer.build(view, depth, kNear);
        for (int i = 0; i < 50; ++i) {
            const int px = int(random.below(kWidth)), py = int(random.below(kHeight));
            const double at_m = random.in(1.0, 150.0);
            const DVec3 point = view.position + at_m * DVec3(view.direction(px, py));
            const double half = random.in(0.0, 10.0);
            const bool is_hidden = buffer.is_hidden(box_at(point + DVec3(random.in(-half, half)), half));
            // The box holds a point that the pixel's ray meets at this depth.
            if (kNear / at_m > double(depth[std::size_t(py) * kWidth + std::size_t(px)])) {
                EXPECT_FALSE(is_hidden) << "box " << i;
                ++shown;
            }
            hidden += is_hidden;
        }
    }
    EXPECT_GT(shown, 1000);
    EXPECT_GT(hidden, 500);
}

}  // namespace
}  // namespace ff::visibility
