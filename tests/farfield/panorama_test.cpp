// The panorama with Embree as its caster and a colour made of what is seen, so that no shading is needed.

#include "engine/farfield/panorama.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/ray_caster.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

using scene::SceneData;
using scene::StaticScene;

constexpr int kWidth = 160, kHeight = 128;

std::vector<TileRequest> all_tiles() {
    std::vector<TileRequest> tiles;
    for (int y = 0; y < kHeight; y += kTileSize)
        for (int x = 0; x < kWidth; x += kTileSize) {
            TileRequest tile{std::uint16_t(x), std::uint16_t(y), {}};
            std::fill(std::begin(tile.rows), std::end(tile.rows), std::uint16_t(0xFFFF));
            tiles.push_back(tile);
        }
    return tiles;
}

std::uint64_t count_pixels(std::span<const TileRequest> tiles) {
    std::uint64_t count = 0;
    for (const TileRequest& tile : tiles)
        for (const std::uint16_t row : tile.rows) count += std::uint64_t(std::popcount(row));
    return count;
}

/// A smooth colour of the point that is seen, different for every triangle.
std::uint32_t color_of(const PinholeView& view, int x, int y, std::uint32_t instance, std::uint32_t triangle,
                       float depth) {
    if (instance == kSkyInstance) return 0xFFFFC080u;
    const DVec3 p = view.position + double(depth) * DVec3(view.direction(x, y));
    const auto wave = [](double v) { return std::uint32_t(40.0 + 30.0 * std::sin(0.05 * v)); };
    const std::uint32_t id = (instance * 31u + triangle) * 2654435761u;
    return 0xFF000000u | (wave(p.x) + (id >> 30) * 40u) | (wave(p.y) + (id >> 28 & 3u) * 40u) << 8 | wave(p.z) << 16;
}

void paint(const PinholeView& view, std::span<const TileRequest> tiles, const VisibilityBuffer& seen,
           std::vector<std::uint32_t>& colors) {
    colors.resize(seen.instance.size());
    for (const TileRequest& tile : tiles)
        for (int j = 0; j < kTileSize; ++j)
            for (int i = 0; i < kTileSize; ++i) {
                if ((tile.rows[j] >> i & 1) == 0) continue;
                const std::size_t at = seen.index(tile.x + i, tile.y + j);
                colors[at] =
                    color_of(view, tile.x + i, tile.y + j, seen.instance[at], seen.triangle[at], seen.depth[at]);
            }
}

/// A world, its caster, a panorama, and the steps that a frame makes with them.
struct Rig {
    explicit Rig(SceneData data, const PanoramaSettings& settings = {.face_size = 256})
        : world(std::move(data)), scene(world.view()), caster(make_embree_caster(scene)), panorama(settings) {
        visibility.resize(kWidth, kHeight);
        colors.assign(visibility.instance.size(), 0);
    }

    std::uint64_t fill(const PinholeView& view, const PanoramaLimits& limits = {}) {
        const std::uint64_t texels = panorama.plan_fill(view, all_tiles(), limits);
        for (int face = 0; face < 6; ++face) {
            const auto requests = panorama.fill_requests(face);
            caster->cast_tiles(panorama.face_view(face), requests, panorama.map());
            paint(panorama.face_view(face), requests, panorama.map(), map_colors);
            map_colors.resize(panorama.map().instance.size());
            panorama.commit_fill(face, map_colors, panorama.map().stride);
        }
        return texels;
    }
    PanoramaStats lookup(const PinholeView& view, const PanoramaLimits& limits = {}) {
        return panorama.lookup(view, all_tiles(), limits, {&visibility, colors.data(), visibility.stride}, to_cast);
    }
    void cast_rest(const PinholeView& view) {
        caster->cast_tiles(view, to_cast, visibility);
        paint(view, to_cast, visibility, colors);
        panorama.store(view, to_cast, visibility, colors, visibility.stride);
    }

    SceneData world;
    StaticScene scene;
    std::unique_ptr<RayCaster> caster;
    Panorama panorama;
    VisibilityBuffer visibility;
    std::vector<std::uint32_t> colors, map_colors;
    std::vector<TileRequest> to_cast;
};

PinholeView view_at(const WorldPos& position, double yaw, double pitch = 0, double roll = 0) {
    Camera camera;
    camera.position = position;
    camera.yaw = yaw;
    camera.pitch = pitch;
    camera.roll = roll;
    return make_view(camera, kWidth, kHeight);
}

/// Mean square difference to casting every pixel, as PSNR.
double psnr_to_full_cast(Rig& rig, const PinholeView& view) {
    VisibilityBuffer seen;
    seen.resize(kWidth, kHeight);
    std::vector<std::uint32_t> reference;
    rig.caster->cast_tiles(view, all_tiles(), seen);
    paint(view, all_tiles(), seen, reference);
    double sum = 0;
    for (std::size_t i = 0; i < reference.size(); ++i)
        for (int shift = 0; shift < 24; shift += 8) {
            const double d = double(reference[i] >> shift & 255) - double(rig.colors[i] >> shift & 255);
            sum += d * d;
        }
    return 10 * std::log10(255.0 * 255.0 / std::max(1e-9, sum / (3.0 * double(reference.size()))));
}

const WorldPos kEye(3, 12, 5);

TEST(Panorama, AnswersATurnOnTheSpotAsAFullCastDoes) {
    Rig rig(test::make_city({.cells = 2}));
    for (int frame = 0; frame < 24; ++frame) {
        const PinholeView view = view_at(kEye, 0.3 * frame, 0.4 * std::sin(0.7 * frame), 0.1 * frame);
        rig.panorama.begin_frame(view.position);
        rig.fill(view);
        const PanoramaStats stats = rig.lookup(view);
        EXPECT_EQ(stats.wanted, std::uint64_t(kWidth * kHeight));
        EXPECT_EQ(stats.cast, stats.edges) << "frame " << frame;  // nothing was never seen
        EXPECT_EQ(stats.stale + stats.unanswered, 0u);
        EXPECT_EQ(stats.parallax_max_px, 0.0f);
        EXPECT_EQ(count_pixels(rig.to_cast), stats.cast);
        rig.cast_rest(view);
        EXPECT_GT(psnr_to_full_cast(rig, view), 36.0) << "frame " << frame;
    }
}

TEST(Panorama, FillsNothingWhereEverythingWasSeen) {
    Rig rig(test::make_city({.cells = 2}));
    const PinholeView view = view_at(kEye, 1.0);
    rig.panorama.begin_frame(kEye);
    EXPECT_GT(rig.fill(view), 0u);
    rig.panorama.begin_frame(kEye);
    EXPECT_EQ(rig.fill(view), 0u);
    EXPECT_LT(rig.fill(view_at(kEye, 1.02)), 6u * 16u * 256u);  // a column or two at the border
}

TEST(Panorama, TellsWhatMarkedPixelsSeeAndWhatWholeTilesDo) {
    Rig rig(test::make_city({.cells = 2}));
    const PinholeView view = view_at(kEye, 0.4, -0.1);
    const auto is_marked = [](std::uint32_t instance, std::uint32_t triangle) {
        return instance != kSkyInstance && (instance + triangle) % 5 == 0;
    };
    rig.panorama.begin_frame(kEye);
    rig.panorama.plan_fill(view, all_tiles(), {});
    for (int face = 0; face < 6; ++face) {
        const auto requests = rig.panorama.fill_requests(face);
        const VisibilityBuffer& map = rig.panorama.map();
        rig.caster->cast_tiles(rig.panorama.face_view(face), requests, rig.panorama.map());
        paint(rig.panorama.face_view(face), requests, map, rig.map_colors);
        std::vector<TileMask> marks(requests.size());
        for (std::size_t r = 0; r < requests.size(); ++r)
            for (int j = 0; j < kTileSize; ++j)
                for (int i = 0; i < kTileSize; ++i) {
                    const std::size_t at = map.index(requests[r].x + i, requests[r].y + j);
                    const bool marked = is_marked(map.instance[at], map.triangle[at]);
                    marks[r].rows[j] = std::uint16_t(marks[r].rows[j] | unsigned(marked) << i);
                }
        rig.panorama.commit_fill(face, rig.map_colors, map.stride, marks);
    }
    VisibilityBuffer all = rig.visibility;
    const PanoramaLimits limits{.edges = EdgeRule::blend};
    rig.panorama.lookup(view, all_tiles(), limits, {&all, rig.colors.data(), all.stride}, rig.to_cast);

    constexpr std::uint32_t kUntouched = 0xABCDu;
    std::fill(rig.visibility.triangle.begin(), rig.visibility.triangle.end(), kUntouched);
    std::vector<std::uint8_t> whole(all_tiles().size(), 0);
    whole[13] = 1;
    PixelMask named;
    const PanoramaTarget target{.visibility = &rig.visibility,
                                .colors = rig.colors.data(),
                                .color_stride = rig.visibility.stride,
                                .depths = false,
                                .names = PanoramaNames::marked,
                                .whole = whole,
                                .named = &named};
    rig.panorama.lookup(view, all_tiles(), limits, target, rig.to_cast);
    std::uint64_t marked = 0, outside_of_whole = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const std::size_t at = all.index(x, y);
            const bool is_whole = whole[std::size_t(y / kTileSize * (kWidth / kTileSize) + x / kTileSize)] != 0;
            const bool expected = is_whole || is_marked(all.instance[at], all.triangle[at]);
            ASSERT_EQ(named.test(x, y), expected) << x << ", " << y;
            marked += expected ? 1 : 0;
            outside_of_whole += expected && !is_whole ? 1 : 0;
            if (!expected) {
                ASSERT_EQ(rig.visibility.triangle[at], kUntouched);
                continue;
            }
            ASSERT_EQ(rig.visibility.instance[at], all.instance[at]);
            ASSERT_EQ(rig.visibility.triangle[at], all.triangle[at]);
            ASSERT_EQ(rig.visibility.depth[at], all.depth[at]);
        }
    EXPECT_GT(outside_of_whole, 500u);
    EXPECT_LT(marked, std::uint64_t(kWidth * kHeight) * 3 / 4);
}

TEST(Panorama, HasNoSeamsAtPolesAndFaceEdgesAtAnyRoll) {
    // From within a sphere of one triangle's colour steps, every pixel must be answered with the right distance.
    Rig rig(test::make_closed_sphere(40, 24));
    for (const double pitch : {-1.5707, -0.9, -0.615, 0.0, 0.615, 1.5707})
        for (const double yaw : {0.0, 0.7854, 2.3562, 3.0})
            for (const double roll : {0.0, 0.5, 1.5708}) {
                const PinholeView view = view_at(WorldPos(0.0), yaw, pitch, roll);
                rig.panorama.begin_frame(view.position);
                rig.fill(view);
                rig.visibility.resize(kWidth, kHeight);
                const PanoramaStats stats = rig.lookup(view, {.edges = EdgeRule::blend});
                ASSERT_EQ(stats.reused, stats.wanted) << pitch << " " << yaw << " " << roll;
                for (int y = 0; y < kHeight; ++y)
                    for (int x = 0; x < kWidth; ++x) {
                        const std::size_t at = rig.visibility.index(x, y);
                        const double distance =
                            double(rig.visibility.depth[at]) * glm::length(DVec3(view.direction(x, y)));
                        ASSERT_EQ(rig.visibility.instance[at], 0u);
                        ASSERT_NEAR(distance, 39.7, 0.5)
                            << x << ", " << y << " at " << pitch << " " << yaw << " " << roll;
                    }
            }
}

TEST(Panorama, DepthsFollowAViewerWhoMoves) {
    Rig rig(test::make_closed_sphere(40, 24));
    rig.panorama.begin_frame(WorldPos(0.0));
    rig.fill(view_at(WorldPos(0.0), 0.3));
    const WorldPos moved(0.1, 0.05, -1.0);
    const PinholeView view = view_at(moved, 0.3);
    rig.panorama.begin_frame(moved);
    const PanoramaStats stats = rig.lookup(view, {.max_parallax_px = 100, .edges = EdgeRule::blend});
    EXPECT_EQ(stats.reused, stats.wanted);
    for (int y = 0; y < kHeight; y += 5)
        for (int x = 0; x < kWidth; x += 5) {
            const DVec3 point =
                moved + double(rig.visibility.depth[rig.visibility.index(x, y)]) * DVec3(view.direction(x, y));
            ASSERT_NEAR(glm::length(point), 39.7, 0.7);
        }
}

/// Parallax of what the lookup reused, computed anew from the record's position, which is the only other one.
TEST(Panorama, ReusesNothingAboveTheParallaxLimitWhenTheBudgetSuffices) {
    for (const bool by_fill : {true, false}) {
        Rig rig(test::make_city({.cells = 2}));
        const PinholeView before = view_at(kEye, 0.5);
        rig.panorama.begin_frame(kEye);
        if (by_fill) rig.fill(before);
        rig.lookup(before);
        rig.cast_rest(before);
        const WorldPos moved = kEye + DVec3(0.15, 0.02, -0.1);
        const PinholeView view = view_at(moved, 0.52);
        rig.panorama.begin_frame(moved);
        const PanoramaLimits limits{.max_parallax_px = 0.5f, .edges = EdgeRule::blend};
        const PanoramaStats stats = rig.lookup(view, limits);
        EXPECT_GT(stats.reused, 0u);
        EXPECT_GT(stats.cast, 0u);
        EXPECT_EQ(stats.stale, 0u);
        EXPECT_LE(stats.parallax_max_px, 0.5f * 1.13f);  // a bin's width
        std::vector<bool> cast(rig.visibility.instance.size(), false);
        for (const TileRequest& tile : rig.to_cast)
            for (int j = 0; j < kTileSize; ++j)
                for (int i = 0; i < kTileSize; ++i)
                    if (tile.rows[j] >> i & 1) cast[rig.visibility.index(tile.x + i, tile.y + j)] = true;
        const DVec3 e = moved - kEye;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const std::size_t at = rig.visibility.index(x, y);
                if (cast[at] || rig.visibility.instance[at] == kSkyInstance) continue;
                const DVec3 d(view.direction(x, y));
                const double depth = rig.visibility.depth[at];
                const DVec3 across = e - d * (glm::dot(e, d) / glm::dot(d, d));
                const double parallax = glm::length(across) / (depth * glm::length(d)) / double(view.pixel_angle());
                ASSERT_LE(parallax, 0.51) << x << ", " << y;
            }
    }
}

TEST(Panorama, ReusesByDistanceAsInTheFirstPaperWhenAsked) {
    Rig rig(test::make_city({.cells = 2}));
    const PinholeView view = view_at(kEye, 0.5);
    rig.panorama.begin_frame(kEye);
    rig.fill(view);
    const WorldPos moved = kEye + DVec3(0.2, 0, 0);
    const PinholeView later = view_at(moved, 0.5);
    rig.panorama.begin_frame(moved);
    PanoramaLimits limits{.measure = ConfidenceMeasure::distance, .max_distance_m = 0.25f, .edges = EdgeRule::blend};
    EXPECT_GT(rig.lookup(later, limits).reused, std::uint64_t(kWidth * kHeight * 95 / 100));
    limits.max_distance_m = 0.15f;
    EXPECT_EQ(rig.lookup(later, limits).reused, 0u);
}

TEST(Panorama, KnowsWhetherAFillLeftAnythingOut) {
    const PinholeView view = view_at(kEye, 0.5);
    Rig all(test::make_city({.cells = 2}));
    all.panorama.begin_frame(kEye);
    const std::uint64_t texels = all.fill(view);
    EXPECT_TRUE(all.panorama.is_fill_complete());
    int with_room = 0;
    for (std::uint64_t budget = texels + 256; budget > 1000; budget -= budget / 7) {
        Rig rig(test::make_city({.cells = 2}));
        rig.panorama.begin_frame(kEye);
        const std::uint64_t filled = rig.fill(view, {.ray_budget = budget});
        const bool is_complete = rig.panorama.is_fill_complete();
        with_room += filled + 256 <= budget && filled < texels;
        EXPECT_EQ(rig.panorama.plan_fill(view, all_tiles(), {}) == 0, is_complete) << budget << " of " << texels;
        for (bool done = is_complete; !done; done = rig.panorama.is_fill_complete())
            ASSERT_GT(rig.fill(view, {.ray_budget = budget}), 0u);
        EXPECT_EQ(rig.panorama.plan_fill(view, all_tiles(), {}), 0u) << "little by little";
    }
    EXPECT_GT(with_room, 0) << "a budget with room for more says nothing: of equals every n-th is taken";
}

TEST(Panorama, SpendsItsBudgetExactlyAndOnTheWorstFirst) {
    Rig rig(test::make_city({.cells = 2}));
    const PinholeView view = view_at(kEye, 0.5);
    rig.panorama.begin_frame(kEye);
    for (const std::uint64_t budget : {std::uint64_t(0), std::uint64_t(1), std::uint64_t(777), std::uint64_t(12345)}) {
        PanoramaLimits limits{.ray_budget = budget};
        const PanoramaStats stats = rig.lookup(view, limits);
        EXPECT_EQ(stats.cast, budget);
        EXPECT_EQ(count_pixels(rig.to_cast), budget);
        EXPECT_EQ(stats.unanswered, stats.wanted - budget);
        EXPECT_LE(rig.panorama.plan_fill(view, all_tiles(), limits), budget);
    }
    // Half of the view is known but stale, half was never seen: the budget goes to the latter.
    rig.fill(view);
    const WorldPos moved = kEye + DVec3(2, 0, 0);
    const PinholeView later = view_at(moved, 1.0);
    rig.panorama.begin_frame(moved);
    const PanoramaStats all = rig.lookup(later, {.edges = EdgeRule::blend});
    const PanoramaStats none = rig.lookup(later, {.edges = EdgeRule::blend, .ray_budget = 0});
    ASSERT_GT(none.unanswered, 0u);
    ASSERT_GT(all.cast, none.unanswered);
    const PanoramaStats some = rig.lookup(later, {.edges = EdgeRule::blend, .ray_budget = none.unanswered + 10});
    EXPECT_EQ(some.cast, none.unanswered + 10);
    EXPECT_EQ(some.unanswered, 0u);
    EXPECT_EQ(some.stale, all.cast - some.cast);
    EXPECT_GT(some.parallax_max_px, 0.7f);
}

TEST(Panorama, CatchesUpWhenTheViewerRests) {
    Rig rig(test::make_city({.cells = 2}));
    const PinholeView view = view_at(kEye, 0.5);
    std::uint64_t unanswered = kWidth * kHeight;
    for (int frame = 0; frame < 40 && unanswered > 0; ++frame) {
        rig.panorama.begin_frame(kEye);
        rig.fill(view, {.ray_budget = 4096});
        unanswered = rig.lookup(view, {.edges = EdgeRule::blend, .ray_budget = 0}).unanswered;
    }
    EXPECT_EQ(unanswered, 0u);
}

TEST(Panorama, StoredPixelsComeBack) {
    Rig rig(test::make_city({.cells = 2}), {.face_size = 128});
    const PinholeView view = view_at(kEye, 0.5);
    rig.panorama.begin_frame(kEye);
    EXPECT_EQ(rig.lookup(view).cast, std::uint64_t(kWidth * kHeight));
    rig.cast_rest(view);
    const PanoramaStats stats = rig.lookup(view, {.edges = EdgeRule::blend});
    EXPECT_GT(stats.reused, std::uint64_t(kWidth * kHeight * 9 / 10));
    EXPECT_GT(psnr_to_full_cast(rig, view), 22.0);
    EXPECT_EQ(rig.panorama.age(view.direction(80, 64)), 0);
    rig.panorama.begin_frame(kEye);
    EXPECT_EQ(rig.panorama.age(view.direction(80, 64)), 1);
    EXPECT_EQ(rig.panorama.age(-view.direction(80, 64)), -1);
}

TEST(Panorama, InvalidatesExactlyTheTexelsWhoseRaysMeetTheBox) {
    Rig rig(test::make_closed_sphere(40, 24));
    for (int frame = 0; frame < 24; ++frame) {
        const PinholeView view = view_at(WorldPos(0.0), 1.0471976 * (frame % 6), frame / 6 * 0.9 - 1.35);
        rig.panorama.begin_frame(WorldPos(0.0));
        rig.fill(view);
    }
    const DBox3 box{DVec3(8, 3, -12), DVec3(12, 6, -9)};
    const DBox3 outside{DVec3(50, 0, 0), DVec3(60, 10, 10)};
    EXPECT_EQ(rig.panorama.invalidate(outside), 0u);
    EXPECT_GT(rig.panorama.invalidate(box), 0u);
    EXPECT_EQ(rig.panorama.invalidate(box), 0u);
    int hits = 0;
    test::Random random(1);
    for (int i = 0; i < 20000; ++i) {
        const Vec3 d = random.in_box(Vec3(-1), Vec3(1));
        if (glm::length(d) < 0.1f) continue;
        double enter = 0, leave = 1e9, margin_enter = 0, margin_leave = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
            const auto cut = [&](double grow, double& from, double& to) {
                const double a = (box.low[axis] - grow) / d[axis], b = (box.high[axis] + grow) / d[axis];
                from = std::max(from, std::min(a, b));
                to = std::min(to, std::max(a, b));
            };
            cut(0.2, enter, leave);  // 0.2 m at the box: more than a texel
            cut(-0.2, margin_enter, margin_leave);
        }
        const std::int64_t age = rig.panorama.age(d);
        if (margin_enter < margin_leave) {
            ++hits;
            ASSERT_EQ(age, -1) << d.x << ", " << d.y << ", " << d.z;
        } else if (enter > leave) {
            ASSERT_GE(age, 0) << d.x << ", " << d.y << ", " << d.z;
        }
    }
    EXPECT_GT(hits, 20);
}

TEST(Panorama, ForgetsTexelsOfRecordsThatAreUsedAgain) {
    Rig rig(test::make_closed_sphere(4000, 12), {.face_size = 64});
    rig.panorama.begin_frame(WorldPos(0.0));
    const PinholeView view = view_at(WorldPos(0.0), 0.0);
    rig.fill(view);
    const Vec3 ahead = view.direction(kWidth / 2, kHeight / 2);
    std::int64_t last_age = 0;
    for (int frame = 1; frame < 9000; ++frame) {
        rig.panorama.begin_frame(WorldPos(0.002 * frame, 0, 0));
        const std::int64_t age = rig.panorama.age(ahead);
        if (age < 0) {
            EXPECT_GT(last_age, 3000);
            EXPECT_LT(last_age, 4096);
            return;
        }
        ASSERT_EQ(age, frame);
        last_age = age;
    }
    FAIL() << "never forgotten";
}

TEST(Panorama, GivesTheSameBitsForOneAndTwoWorkers) {
    std::vector<std::uint32_t> first_colors;
    ZeroPageVector<float> first_depths;
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        Rig rig(test::make_city({.cells = 2}));
        for (int frame = 0; frame < 8; ++frame) {
            const WorldPos position = kEye + DVec3(0.05 * frame, 0, 0.02 * frame);
            const PinholeView view = view_at(position, 0.2 * frame, 0.1 * frame);
            rig.panorama.begin_frame(position);
            const PanoramaLimits limits{.ray_budget = 5000};
            if (frame % 3 == 0) rig.fill(view, limits);
            rig.lookup(view, limits);
            rig.cast_rest(view);
        }
        if (workers == 1) {
            first_colors = rig.colors;
            first_depths = rig.visibility.depth;
        } else {
            EXPECT_EQ(rig.colors, first_colors);
            EXPECT_EQ(rig.visibility.depth, first_depths);
        }
    }
}

TEST(Panorama, KnowsNothingAfterItWasCleared) {
    Rig rig(test::make_city({.cells = 2}));
    const PinholeView view = view_at(kEye, 0.4);
    rig.panorama.begin_frame(kEye);
    const std::uint64_t texels = rig.fill(view);
    EXPECT_GE(rig.panorama.age(view.direction(kWidth / 2, kHeight / 2)), 0);
    rig.panorama.clear();
    EXPECT_EQ(rig.panorama.age(view.direction(kWidth / 2, kHeight / 2)), -1);
    EXPECT_EQ(rig.lookup(view).cast, std::uint64_t(kWidth * kHeight));
    EXPECT_EQ(rig.fill(view), texels);
}

TEST(Panorama, VerifiedEdgesSeeWhatTheirPixelsSee) {
    constexpr std::uint32_t kUntouched = 0xFFFFFFFEu;
    VisibilityBuffer first;
    std::vector<std::uint32_t> first_colors;
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        Rig rig(test::make_city({.cells = 2}));
        PixelMask left;
        std::uint64_t edges = 0, differ = 0, coloured = 0, off = 0;
        for (int frame = 0; frame < 8; ++frame) {
            const PinholeView view = view_at(kEye, 0.5 * frame, 0.3 * std::sin(0.7 * frame), 0.2 * frame);
            rig.panorama.begin_frame(kEye);
            rig.fill(view);
            const PanoramaStats stats = rig.lookup(view, {.edges = EdgeRule::verify});
            std::fill(rig.visibility.instance.begin(), rig.visibility.instance.end(), kUntouched);
            left.reset(kWidth, kHeight);
            rig.panorama.verify_edges(rig.scene, view, {nullptr, rig.colors.data(), rig.visibility.stride},
                                      rig.visibility, left);
            VisibilityBuffer seen;
            seen.resize(kWidth, kHeight);
            rig.caster->cast_tiles(view, all_tiles(), seen);
            std::uint64_t met = 0;
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) {
                    const std::size_t at = seen.index(x, y);
                    if (rig.visibility.instance[at] == kUntouched) {
                        EXPECT_FALSE(left.test(x, y));
                        continue;
                    }
                    ++met;
                    const bool same = rig.visibility.instance[at] == seen.instance[at] &&
                                      rig.visibility.triangle[at] == seen.triangle[at];
                    differ += !same;
                    if (left.test(x, y)) continue;
                    // Painted triangle by triangle: another one's colour is far off.
                    ++coloured;
                    const std::uint32_t own = color_of(view, x, y, rig.visibility.instance[at],
                                                       rig.visibility.triangle[at], rig.visibility.depth[at]);
                    int most = 0;
                    for (int shift = 0; shift < 24; shift += 8)
                        most = std::max(most, std::abs(int(own >> shift & 255u) - int(rig.colors[at] >> shift & 255u)));
                    off += most > 12;
                }
            edges += met;
            EXPECT_LE(stats.cast + met, stats.wanted);
        }
        EXPECT_GT(edges, 1000u);
        EXPECT_LT(differ * 50, edges) << differ << " of " << edges;
        EXPECT_GT(coloured * 10, edges * 8) << coloured << " of " << edges;
        EXPECT_LT(off * 50, coloured) << off << " of " << coloured;
        if (workers == 1) {
            first = rig.visibility;
            first_colors = rig.colors;
        } else {
            EXPECT_EQ(rig.visibility.instance, first.instance);
            EXPECT_EQ(rig.visibility.triangle, first.triangle);
            EXPECT_EQ(rig.visibility.depth, first.depth);
            EXPECT_EQ(rig.colors, first_colors);
        }
    }
}

TEST(Panorama, LeavesPixelsThatNobodyWantsAsTheyWere) {
    Rig rig(test::make_city({.cells = 2}));
    const PinholeView view = view_at(kEye, 0.5);
    rig.panorama.begin_frame(kEye);
    rig.fill(view);
    std::fill(rig.colors.begin(), rig.colors.end(), 0x12345678u);
    TileRequest tile{32, 48, {}};
    tile.rows[3] = 0x0120;
    const std::vector<TileRequest> wanted = {tile};
    rig.visibility.resize(kWidth, kHeight);
    const PanoramaStats stats =
        rig.panorama.lookup(view, wanted, {.edges = EdgeRule::blend},
                            {&rig.visibility, rig.colors.data(), rig.visibility.stride}, rig.to_cast);
    EXPECT_EQ(stats.wanted, 2u);
    EXPECT_EQ(stats.reused, 2u);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const bool is_wanted = y == 51 && (x == 37 || x == 40);
            const std::size_t at = rig.visibility.index(x, y);
            ASSERT_EQ(rig.colors[at] != 0x12345678u, is_wanted);
            ASSERT_EQ(rig.visibility.instance[at] != kUnresolved, is_wanted);
        }
}

}  // namespace
}  // namespace ff::farfield
