// Where shadows of what moves may fall, against double precision, pixel by pixel.

#include "engine/farfield/moving_shadow.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <string>

#include "tests/support/tiles.h"

namespace ff::farfield {
namespace {

constexpr int kWidth = 96, kHeight = 64;

using Random = std::mt19937;

double uniform(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}

DVec3 direction(Random& random) {
    for (;;) {
        const DVec3 v(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
        const double length = glm::length(v);
        if (length > 0.1 && length < 1.0) return v / length;
    }
}

/// A view of surfaces at random depths, things that move around the viewer, and a sun.
struct Case {
    PinholeView view;
    VisibilityBuffer visibility;
    std::vector<MovingSphere> moving;
    Vec3 to_sun;

    explicit Case(Random& random) : to_sun(direction(random)) {
        Camera camera;
        camera.position = DVec3(uniform(random, -1e5, 1e5), 50.0, uniform(random, -1e5, 1e5));
        camera.yaw = uniform(random, -3.14, 3.14);
        camera.pitch = uniform(random, -1.0, 1.0);
        camera.vertical_fov = uniform(random, 0.1, 1.7);
        view = make_view(camera, kWidth, kHeight);
        visibility.resize(kWidth, kHeight);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const std::size_t at = visibility.index(x, y);
                const bool is_sky = random() % 8 == 0;
                visibility.instance[at] = is_sky ? kSkyInstance : std::uint32_t(random() % 5);
                visibility.depth[at] =
                    is_sky ? std::numeric_limits<float>::infinity() : float(std::exp(uniform(random, -1, 9)));
            }
        const std::size_t count = random() % 40;
        for (std::size_t i = 0; i < count; ++i) {
            const double radius = std::exp(uniform(random, -2, 3)), distance = std::exp(uniform(random, -1, 8));
            MovingSphere ball{camera.position + direction(random) * distance, radius, {}};
            if (random() % 2 == 0) {
                const DVec3 half = glm::abs(direction(random)) * radius;
                ball.box = {ball.center - half, ball.center + half};
            }
            moving.push_back(ball);
        }
    }

    [[nodiscard]] bool sees_surface(int x, int y) const {
        return visibility.instance[visibility.index(x, y)] < kUnresolved;
    }

    /// Whether something stands between the sun and what a pixel sees, itself `grown` times a pixel's width larger.
    [[nodiscard]] bool is_shaded(int x, int y, double grown) const {
        const double depth = visibility.depth[visibility.index(x, y)], more = grown * view.pixel_angle() * depth;
        const DVec3 in_camera((x + 0.5) * view.u_step + view.u_first, (y + 0.5) * view.v_step + view.v_first, -1.0);
        const DVec3 from = view.position + DMat3(view.world_from_camera) * in_camera * depth, sun(to_sun);
        for (const MovingSphere& ball : moving) {
            const DVec3 to = ball.center - from;
            // Grown shadows begin as bluntly as cylinders do.
            const double blunt = grown > 0.0 ? ball.radius + more : 0.0;
            const DVec3 beside = to - std::max(-blunt, glm::dot(to, sun)) * sun;
            if (glm::length(beside) > ball.radius + more) continue;
            if (ball.box.is_empty()) return true;
            const DBox3 box{ball.box.low - more, ball.box.high + more};
            if (meets_segment(box, from - sun * (2.0 * blunt),
                              sun * (2.0 * blunt + glm::length(to) + 2.0 * (ball.radius + more))))
                return true;
        }
        return false;
    }
};

TEST(moving_shadow, all_that_is_shaded_is_found_and_little_beside) {
    Random random(20261123);
    std::size_t shaded = 0, found = 0, tiles_asked = 0, tiles_into = 0;
    for (int round = 0; round < 300; ++round) {
        const Case c(random);
        SCOPED_TRACE("round " + std::to_string(round));
        MovingShadows shadows;
        shadows.begin(c.view, c.moving, c.to_sun);
        EXPECT_EQ(shadows.is_empty(), c.moving.empty());
        MovingShadows one;
        one.begin(c.view, std::span(c.moving).first(std::min<std::size_t>(1, c.moving.size())), c.to_sun);
        for (TileRequest tile : test::all_tiles(kWidth, kHeight)) {
            for (std::uint16_t& row : tile.rows) row = std::uint16_t(random());
            TileRequest left = tile;
            const bool any = shadows.find(c.visibility, left);
            EXPECT_EQ(any, !left.is_empty());
            tiles_into += one.may_fall_into(tile);
            ++tiles_asked;
            for (int j = 0; j < kTileSize; ++j)
                for (int i = 0; i < kTileSize; ++i) {
                    const bool asked = (tile.rows[j] >> i & 1) != 0, is_found = (left.rows[j] >> i & 1) != 0;
                    if (!asked || !c.sees_surface(tile.x + i, tile.y + j)) {
                        ASSERT_FALSE(is_found) << "nobody asked, or nothing is there";
                        continue;
                    }
                    const bool is_shaded = c.is_shaded(tile.x + i, tile.y + j, 0.0);
                    ASSERT_TRUE(is_found || !is_shaded) << "pixel " << tile.x + i << ", " << tile.y + j;
                    ASSERT_TRUE(!is_found || c.is_shaded(tile.x + i, tile.y + j, 8.0))
                        << "far from any shadow: pixel " << tile.x + i << ", " << tile.y + j;
                    shaded += is_shaded;
                    found += is_found;
                }
        }
    }
    EXPECT_GT(shaded, 10000u);
    EXPECT_LT(found, 2 * shaded);
    EXPECT_LT(tiles_into, tiles_asked / 3);
    EXPECT_GT(tiles_into, tiles_asked / 50);
}

TEST(moving_shadow, a_viewer_in_a_shadow_and_tiles_towards_the_sun_are_asked) {
    Camera camera;
    camera.pitch = 0.5;
    const PinholeView view = make_view(camera, kWidth, kHeight);
    const MovingSphere above{camera.position + DVec3(0.0, 40.0, 0.0), 1.0, {}};
    MovingShadows shadows;
    shadows.begin(view, {&above, 1}, {0.0f, 1.0f, 0.0f});
    for (const TileRequest& tile : test::all_tiles(kWidth, kHeight)) EXPECT_TRUE(shadows.may_fall_into(tile));

    // A sun right before the viewer: the shadow of what is far behind him falls towards him from nowhere that he sees.
    const DVec3 ahead = DVec3(view.direction(kWidth / 2, kHeight / 2));
    const MovingSphere behind{camera.position - glm::normalize(ahead) * 300.0 + DVec3(20.0, 0.0, 0.0), 1.0, {}};
    shadows.begin(view, {&behind, 1}, Vec3(glm::normalize(ahead)));
    std::size_t asked = 0;
    for (const TileRequest& tile : test::all_tiles(kWidth, kHeight)) asked += shadows.may_fall_into(tile);
    EXPECT_LE(asked, 4u) << "but where the sun itself may be";
    shadows.begin(view, {}, {0.0f, 1.0f, 0.0f});
    EXPECT_FALSE(shadows.may_fall_into(test::all_tiles(kWidth, kHeight)[0]));
}

TEST(moving_shadow, every_width_of_vectors_says_nearly_the_same) {
    const std::int64_t supported = hwy::SupportedTargets();
    std::vector<std::vector<std::uint16_t>> answers;
    for (const std::int64_t target : {HWY_SSE4, HWY_AVX2, HWY_AVX3}) {
        if ((supported & target) == 0) continue;
        hwy::SetSupportedTargetsForTest(target);
        Random random(7);
        std::vector<std::uint16_t>& answer = answers.emplace_back();
        for (int round = 0; round < 20; ++round) {
            const Case c(random);
            MovingShadows shadows;
            shadows.begin(c.view, c.moving, c.to_sun);
            for (TileRequest tile : test::all_tiles(kWidth, kHeight)) {
                (void)shadows.find(c.visibility, tile);
                answer.insert(answer.end(), std::begin(tile.rows), std::end(tile.rows));
            }
        }
    }
    hwy::SetSupportedTargetsForTest(0);
    for (const std::vector<std::uint16_t>& answer : answers) {
        std::size_t different = 0;
        for (std::size_t i = 0; i < answer.size(); ++i) different += answer[i] != answers[0][i];
        EXPECT_LE(different, answer.size() / 1000) << "rows: what lies at a shadow's border may be rounded";
    }
}

}  // namespace
}  // namespace ff::farfield
