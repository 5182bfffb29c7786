// Reused light on a floor whose lit parts are known everywhere: a chessboard of sun and shade.

#include "engine/farfield/sun_history.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tests/support/tiles.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

constexpr int kWidth = 200, kHeight = 120;  // neither is a multiple of a tile
constexpr double kSquareM = 8.0;

/// What a view sees of the floor y = 0, and where the sun is seen there.
struct Floor {
    PinholeView view;
    VisibilityBuffer visibility;
    std::vector<std::uint8_t> lit;  ///< the truth

    explicit Floor(const Camera& camera) : view(make_view(camera, kWidth, kHeight)) {
        visibility.resize(kWidth, kHeight);
        lit.assign(visibility.instance.size(), 0);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const std::size_t at = visibility.index(x, y);
                const DVec3 ray(view.direction(x, y));
                const double depth = -view.position.y / ray.y;
                const bool hits = ray.y < 0.0 && depth < 200.0;
                visibility.instance[at] = hits ? 0 : kSkyInstance;
                visibility.triangle[at] = 0;
                visibility.depth[at] = hits ? float(depth) : std::numeric_limits<float>::infinity();
                if (!hits) continue;
                const DVec3 p = view.position + depth * ray;
                lit[at] =
                    (std::int64_t(std::floor(p.x / kSquareM)) + std::int64_t(std::floor(p.z / kSquareM))) & 1 ? 255 : 0;
            }
    }
    [[nodiscard]] bool is_floor(int x, int y) const { return visibility.instance[visibility.index(x, y)] == 0; }
    /// Whether a border of sun and shade runs within `reach` pixels.
    [[nodiscard]] bool near_border(int x, int y, int reach) const {
        for (int j = std::max(0, y - reach); j <= std::min(kHeight - 1, y + reach); ++j)
            for (int i = std::max(0, x - reach); i <= std::min(kWidth - 1, x + reach); ++i)
                if (lit[visibility.index(i, j)] != lit[visibility.index(x, y)]) return true;
        return false;
    }
};

struct Turn {
    std::uint64_t answered = 0, cast = 0, wrong = 0, wrong_inside = 0;
    std::vector<std::uint8_t> lit;
};

/// One frame: reuse, then the truth for what is left.
Turn take_turn(SunHistory& history, const Floor& floor, int refresh_frames, std::span<const MovingSphere> moving = {},
               const Vec3& to_sun = {0.0f, 1.0f, 0.0f}, std::uint32_t static_instances = 1) {
    Turn turn;
    turn.lit.assign(floor.lit.size(), 7);
    const std::vector<TileRequest> tiles = test::all_tiles(kWidth, kHeight);
    std::vector<TileRequest> left;
    const SunHistoryInput input{.view = floor.view,
                                .visibility = floor.visibility,
                                .tiles = tiles,
                                .static_instances = static_instances,
                                .moving = moving,
                                .to_sun = to_sun,
                                .refresh_frames = refresh_frames};
    turn.answered = history.reuse(input, turn.lit.data(), left);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const std::size_t at = floor.visibility.index(x, y);
            if (turn.lit[at] == 7) continue;
            EXPECT_TRUE(floor.is_floor(x, y));
            turn.wrong += turn.lit[at] != floor.lit[at];
            turn.wrong_inside += turn.lit[at] != floor.lit[at] && !floor.near_border(x, y, 2);
        }
    for (const TileRequest& tile : left)
        for (int j = 0; j < kTileSize; ++j)
            for (int i = 0; i < kTileSize; ++i) {
                if ((tile.rows[j] >> i & 1) == 0) continue;
                const std::size_t at = floor.visibility.index(tile.x + i, tile.y + j);
                EXPECT_EQ(turn.lit[at], 7) << "answered and left";
                turn.lit[at] = floor.lit[at];
                ++turn.cast;
            }
    history.commit(input, left, turn.lit.data());
    return turn;
}

Camera walker(int frame) {
    return {.position = {0.3 + 0.03 * frame, 1.7, -0.05 * frame}, .yaw = 0.004 * frame, .pitch = -0.3};
}

TEST(sun_history, every_floor_pixel_is_answered_or_left_and_those_inside_are_right) {
    SunHistory history;
    std::uint64_t answered = 0, cast = 0, wrong = 0;
    for (int f = 0; f < 60; ++f) {
        const Floor floor(walker(f));
        std::uint64_t pixels = 0;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) pixels += floor.is_floor(x, y);
        const Turn turn = take_turn(history, floor, 32);
        EXPECT_EQ(turn.answered + turn.cast, pixels);
        if (f == 0) {
            EXPECT_EQ(turn.answered, 0u);
            continue;
        }
        // Far squares are smaller than pixels: there anything may be found between two of them.
        answered += turn.answered;
        cast += turn.cast;
        wrong += turn.wrong;
        EXPECT_EQ(turn.wrong_inside, 0u) << "frame " << f;
    }
    EXPECT_GT(answered, cast);
    EXPECT_LE(wrong, answered / 1000);
}

TEST(sun_history, who_rests_is_answered_wholly_but_for_blocks_that_are_due_and_those_come_round) {
    SunHistory history;
    const Floor floor(walker(0));
    const std::uint64_t all = take_turn(history, floor, 8).cast;
    EXPECT_EQ(take_turn(history, floor, 0).cast, 0u);
    EXPECT_EQ(history.age(kWidth / 2, kHeight - 1), 1);
    EXPECT_EQ(history.age(kWidth / 2, 0), -1) << "sky";
    std::uint64_t cast = 0;
    for (int f = 0; f < 8; ++f) {
        const Turn turn = take_turn(history, floor, 8);
        EXPECT_EQ(turn.wrong, 0u);
        cast += turn.cast;
    }
    EXPECT_EQ(cast, all) << "each block once";
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            if (floor.is_floor(x, y)) {
                ASSERT_LT(history.age(x, y), 8);
            }
        }
}

TEST(sun_history, nothing_is_kept_of_another_sun_of_what_moves_and_of_what_shadows_may_cross) {
    SunHistory history;
    const Floor floor(walker(0));
    const std::uint64_t all = take_turn(history, floor, 0).cast;
    EXPECT_EQ(take_turn(history, floor, 0, {}, {0.6f, 0.8f, 0.0f}).cast, all);
    EXPECT_EQ(take_turn(history, floor, 0, {}, {0.6f, 0.8f, 0.0f}).cast, 0u);
    // A ball over the floor before the viewer: its shadow may fall on some of it, this frame and the one after.
    const MovingSphere ball{.center = {2.0, 3.0, -8.0}, .radius = 0.5};
    for (const bool is_there : {true, false}) {
        const Turn turn = take_turn(history, floor, 0, {&ball, is_there ? 1u : 0u}, {0.6f, 0.8f, 0.0f});
        EXPECT_GT(turn.cast, 0u);
        EXPECT_LT(turn.cast, all / 2);
    }
    EXPECT_EQ(take_turn(history, floor, 0, {}, {0.6f, 0.8f, 0.0f}).cast, 0u);
    // One far to the side, whose shadow falls outside of the view.
    const MovingSphere far{.center = {200.0, 3.0, -8.0}, .radius = 0.5};
    EXPECT_EQ(take_turn(history, floor, 0, {&far, 1}, {0.6f, 0.8f, 0.0f}).cast, 0u);
    // The floor itself moves: it has no instance that stands still.
    EXPECT_EQ(take_turn(history, floor, 0, {}, {0.6f, 0.8f, 0.0f}, 0).cast, all);
    EXPECT_EQ(take_turn(history, floor, 0, {}, {0.6f, 0.8f, 0.0f}, 0).cast, all);
    history.clear();
    EXPECT_EQ(take_turn(history, floor, 0, {}, {0.6f, 0.8f, 0.0f}).cast, all);
}

TEST(sun_history, every_width_of_vectors_says_the_same) {
    std::vector<std::vector<std::uint8_t>> answers;
    const std::int64_t supported = hwy::SupportedTargets();
    for (const std::int64_t target : {HWY_SSSE3, HWY_SSE4, HWY_AVX2, HWY_AVX3}) {
        if ((supported & target) == 0) continue;
        hwy::SetSupportedTargetsForTest(target);
        SunHistory history;
        std::vector<std::uint8_t> answer;
        for (int f = 0; f < 6; ++f) {
            const Turn turn = take_turn(history, Floor(walker(3 * f)), 16);
            answer.insert(answer.end(), turn.lit.begin(), turn.lit.end());
        }
        answers.push_back(answer);
    }
    hwy::SetSupportedTargetsForTest(0);
    std::size_t different = 0;
    for (const std::vector<std::uint8_t>& answer : answers)
        for (std::size_t i = 0; i < answer.size(); ++i) different += answer[i] != answers[0][i];
    // Without fused products a point lands a hair beside: now and then in the next pixel.
    EXPECT_LE(different, answers[0].size() / 10000);
}

TEST(sun_history, views_of_any_motion_answer_only_what_they_saw) {
    test::Random random(5);
    SunHistory history;
    for (int f = 0; f < 200; ++f) {
        Camera camera = walker(0);
        camera.position += DVec3(random.in(-30, 30), random.in(0, 20), random.in(-30, 30));
        camera.yaw = random.in(-3, 3);
        camera.pitch = random.in(-1.5, 0.5);
        camera.roll = random.in(-1, 1);
        camera.vertical_fov = random.in(0.1, 2.5);
        const Turn turn = take_turn(history, Floor(camera), 32);
        EXPECT_EQ(turn.wrong_inside, 0u) << "frame " << f;
    }
}

}  // namespace
}  // namespace ff::farfield
