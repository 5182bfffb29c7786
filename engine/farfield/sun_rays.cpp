#include "engine/farfield/sun_rays.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/cast_cost_sum.h"
#include "engine/farfield/sun_group.h"
#include "engine/farfield/sun_points.h"

namespace ff::farfield {

using sun::LightFrame;
using sun::PointGroup;
using sun::PointPool;

float reach_of(const scene::Mesh& mesh, const scene::Instance& instance) {
    const Vec3 reach = glm::max(glm::abs(mesh.bounds.low), glm::abs(mesh.bounds.high));
    const Mat3& m = instance.world_from_mesh;
    return glm::length(glm::abs(m[0]) * reach.x + glm::abs(m[1]) * reach.y + glm::abs(m[2]) * reach.z);
}

SunRays::SunRays(const scene::StaticScene& scene) : scene_(scene), moving_(scene) {}

const scene::StaticScene& SunRays::moving(std::span<const scene::Instance> dynamic) {
    moving_.instances = dynamic;
    moving_.bounds = {};
    for (const scene::Instance& instance : dynamic) moving_.bounds.add(instance.bounds);
    moving_.instance_nodes = moving_bvh_.build(dynamic, scene_.origin);
    return moving_;
}

namespace {

// Tiles of a task at most: neighbours, of which one knows what hid the other.
constexpr std::size_t kTilesPerTask = 16;
static_assert(kTilesPerTask % PointPool::kTiles == 0);

struct KnownOccluders {
    sun::Occluders standing, moving;
};

// Asks for what a tile's pixels see: rows of an image lie too far apart for the processor to see it coming.
void prefetch_tile(const VisibilityBuffer& visibility, const TileRequest& tile, std::uint8_t* lit) {
    for (int row = 0; row < kTileSize; ++row) {
        if (tile.rows[row] == 0) continue;
        const std::size_t at = visibility.index(tile.x, tile.y + row);
        if (at >= visibility.depth.size()) return;
        __builtin_prefetch(&visibility.instance[at]);
        __builtin_prefetch(&visibility.triangle[at]);
        __builtin_prefetch(&visibility.depth[at]);
        __builtin_prefetch(lit + at, 1);
    }
}

// Casts the rays of a pool and writes their answers.
void cast_pool(const scene::StaticScene& scene, const scene::StaticScene& moving, const PointPool& pool,
               const WorldPos& eye, const LightFrame& light, KnownOccluders& known, std::uint8_t* lit, CastCost& cost) {
    PointGroup group;
    for (int first = 0; first < pool.count; first += group.count) {
        make_group(pool, first, eye, light, group);
        cast_group(scene, 0, light, known.standing, group, cost);
        cast_group(moving, std::uint32_t(scene.instances.size()), light, known.moving, group, cost);
        for (int i = 0; i < group.count; ++i) lit[pool.answer[first + i]] = ((group.left >> i) & 1u) != 0 ? 255 : 0;
    }
    cost.rays += std::uint64_t(pool.count);
}

}  // namespace

CastCost SunRays::cast(const PinholeView& view, const VisibilityBuffer& visibility, std::span<const TileRequest> tiles,
                       std::span<const scene::Instance> dynamic, const Vec3& to_sun, std::uint8_t* lit) {
    FF_CHECK(visibility.width >= view.width && visibility.height >= view.height, "view {} x {}, buffer {} x {}",
             view.width, view.height, visibility.width, visibility.height);
    begin_tiles(dynamic, to_sun);
    return cast_tiles(view, visibility, tiles, lit);
}

void SunRays::begin_tiles(std::span<const scene::Instance> dynamic, const Vec3& to_sun) {
    (void)moving(dynamic);
    to_sun_ = to_sun;
}

CastCost SunRays::cast_tiles(const PinholeView& view, const VisibilityBuffer& visibility,
                             std::span<const TileRequest> tiles, std::uint8_t* lit) const {
    const LightFrame light(to_sun_);
    CastCostSum shared;
    parallel_ranges(tiles.size(), uneven_grain(tiles.size(), kTilesPerTask), [&](std::size_t begin, std::size_t end) {
        CastCost cost;
        KnownOccluders known;
        while (begin < end) {
            PointPool pool;
            for (int i = 0; i < PointPool::kTiles && begin < end; ++i)
                gather_tile(scene_, moving_.instances, view, light, visibility, tiles[begin++], lit, pool);
            // While rays are cast, the next tiles' pixels come.
            for (std::size_t i = begin; i < std::min(begin + PointPool::kTiles, tiles.size()); ++i)
                prefetch_tile(visibility, tiles[i], lit);
            cast_pool(scene_, moving_, pool, view.position, light, known, lit, cost);
        }
        shared.add(cost);
    });
    return shared.total();
}

CastCost SunRays::cast_points(const WorldPos& origin, std::span<const SunPoint> points,
                              std::span<const scene::Instance> dynamic, const Vec3& to_sun, std::uint8_t* lit) {
    const scene::StaticScene& others = moving(dynamic);
    const LightFrame light(to_sun);
    CastCostSum shared;
    parallel_ranges(points.size(), PointPool::kMost, [&](std::size_t begin, std::size_t end) {
        CastCost cost;
        KnownOccluders known;
        PointPool pool;
        for (std::size_t i = begin; i < end; ++i) sun::gather_point(points[i], std::uint32_t(i), light, lit, pool);
        cast_pool(scene_, others, pool, origin, light, known, lit, cost);
        shared.add(cost);
    });
    return shared.total();
}

}  // namespace ff::farfield
