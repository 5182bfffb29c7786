// Known primitives against the tile caster, which has to search for them.

#include "engine/farfield/known_primitives.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <vector>

#include "engine/farfield/ray_caster.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

constexpr int kWidth = 152, kHeight = 120;  // no whole number of tiles

template <class Visit>
void visit_pixels(const TileRequest& tile, Visit&& visit) {
    for (int j = 0; j < kTileSize && tile.y + j < kHeight; ++j)
        for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1)
            if (const int i = std::countr_zero(bits); tile.x + i < kWidth) visit(j, i);
}

/// Tiles that ask for all, for a few, and for none of their pixels.
std::vector<TileRequest> some_pixels(std::mt19937& random) {
    std::vector<TileRequest> tiles;
    for (int y = 0; y < kHeight; y += kTileSize)
        for (int x = 0; x < kWidth; x += kTileSize) {
            TileRequest tile{std::uint16_t(x), std::uint16_t(y), {}};
            const auto kind = std::uint32_t(random() % 4);
            for (std::uint16_t& row : tile.rows) {
                const auto few = std::uint32_t(random() & random() & random());
                row = std::uint16_t(kind == 0 ? 0xFFFFu : kind == 1 ? few : kind == 2 ? few & random() & 0x0FF0u : 0u);
            }
            tiles.push_back(tile);
        }
    return tiles;
}

void expect_what_the_caster_finds(const scene::SceneData& world, double spread_m, double eye_m, unsigned seed) {
    const scene::StaticScene scene = world.view();
    const auto caster = make_beam_caster(scene);
    std::mt19937 random(seed);
    std::uint64_t pixels = 0, hits = 0, differ = 0;
    std::vector<PrimitiveId> ids(PrimitiveSet::kCapacity);
    std::vector<KnownTriangle> triangles(PrimitiveSet::kCapacity);
    PrimitiveSet primitives;
    for (int shot = 0; shot < 6; ++shot) {
        std::uniform_real_distribution<double> anywhere(-0.5 * spread_m, 0.5 * spread_m);
        Camera camera;
        camera.position = {anywhere(random), eye_m, anywhere(random)};
        camera.yaw = 1.1 * shot;
        camera.pitch = -0.15;
        camera.roll = 0.2 * shot;
        const PinholeView view = make_view(camera, kWidth, kHeight);
        const beam::BeamView beam_view(view);
        VisibilityBuffer expected, found;
        expected.resize(kWidth, kHeight);
        found.resize(kWidth, kHeight);
        const auto tiles = some_pixels(random);
        caster->cast_tiles(view, tiles, expected);
        for (const TileRequest& tile : tiles) {
            primitives.start(ids);
            visit_pixels(tile, [&](int j, int i) {
                const std::size_t at = expected.index(tile.x + i, tile.y + j);
                primitives.add(expected.instance[at], expected.triangle[at]);
            });
            const auto known = primitives.ids();
            fetch_triangles(scene, known, triangles);
            TileRequest missed;
            cast_known_tile(scene, beam_view, tile, std::span(triangles).first(known.size()), found, missed);
            EXPECT_EQ(missed.x, tile.x);
            EXPECT_EQ(missed.y, tile.y);
            TileRequest seen = tile;
            for (int j = 0; j < kTileSize; ++j) {
                EXPECT_EQ(missed.rows[j] & ~tile.rows[j], 0);
                seen.rows[j] = std::uint16_t(tile.rows[j] & ~missed.rows[j]);
            }
            visit_pixels(tile, [&](int j, int i) {
                const std::size_t at = expected.index(tile.x + i, tile.y + j);
                const bool is_hit = ((seen.rows[j] >> i) & 1) != 0;
                ++pixels;
                hits += is_hit;
                differ += is_hit != (expected.instance[at] != kSkyInstance) ||
                          (is_hit && (found.instance[at] != expected.instance[at] ||
                                      found.triangle[at] != expected.triangle[at] ||
                                      std::fabs(found.depth[at] - expected.depth[at]) > 1e-5f * expected.depth[at]));
                if (!is_hit) {
                    EXPECT_EQ(found.instance[at], kUnresolved) << "a missed pixel was written";
                }
            });
        }
    }
    EXPECT_GT(hits, pixels / 4) << "too much sky to tell";
    EXPECT_LE(differ * 5000, pixels) << differ << " of " << pixels << " pixels, seed " << seed;
}

TEST(KnownPrimitives, AreSeenAsTheTileCasterSeesThem) {
    expect_what_the_caster_finds(test::make_city({.cells = 3, .subdivisions = 3}), 150.0, 6.0, 1);
    expect_what_the_caster_finds(test::make_terrain({.size_m = 1000}), 300.0, 90.0, 2);
}

TEST(KnownPrimitives, MaskedLeavesHaveHoles) {
    expect_what_the_caster_finds(test::make_forest({.trees = 60, .size_m = 60, .masked = true, .leaves = 200}), 30.0,
                                 1.7, 3);
}

TEST(PrimitiveSet, KeepsEachOnceInOrderUpToItsCapacityAndStartsAnew) {
    std::vector<PrimitiveId> room(PrimitiveSet::kCapacity);
    PrimitiveSet set;
    for (int lap = 0; lap < 3; ++lap) {
        set.start(room);
        EXPECT_TRUE(set.ids().empty());
        EXPECT_FALSE(set.add(kSkyInstance, 0));
        std::mt19937 random(static_cast<unsigned>(lap));
        std::vector<PrimitiveId> expected;
        for (int i = 0; i < 4000; ++i) {
            const PrimitiveId id{std::uint32_t(random() % 5), std::uint32_t(random() % 400)};
            const bool is_new = std::find(expected.begin(), expected.end(), id) == expected.end();
            const bool fits = expected.size() < PrimitiveSet::kCapacity;
            EXPECT_EQ(set.add(id.instance, id.triangle), is_new && fits);
            if (is_new && fits) expected.push_back(id);
        }
        EXPECT_TRUE(std::equal(expected.begin(), expected.end(), set.ids().begin(), set.ids().end()));
    }
}

}  // namespace
}  // namespace ff::farfield
