#include "engine/farfield/known_pixels.h"

#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/cast_cost_sum.h"
#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {
namespace {

constexpr std::size_t kTilesPerTask = 8;
constexpr std::size_t kTilesTogether = 4;  // whose primitives are fetched at once

struct Task {
    PrimitiveSet primitives;
    std::array<PrimitiveId, kTilesTogether * PrimitiveSet::kCapacity> ids;
    std::array<KnownTriangle, kTilesTogether * PrimitiveSet::kCapacity> triangles;
    std::array<TileRequest, kTilesTogether> hits;
    std::array<std::size_t, kTilesTogether + 1> first{};
};

/// The pixels of a tile that see something, and their primitives.
TileRequest collect(const PinholeView& view, const TileRequest& tile, const VisibilityBuffer& visibility,
                    PrimitiveSet& primitives) {
    TileRequest hits{tile.x, tile.y, {}};
    PrimitiveId last{kSkyInstance, 0};
    for (int j = 0; j < kTileSize; ++j) {
        const std::uint32_t bits = row_inside(tile, j, view.width, view.height);
        for (std::uint32_t left = bits; left != 0; left &= left - 1) {
            const int i = std::countr_zero(left);
            const std::size_t at = visibility.index(tile.x + i, tile.y + j);
            const PrimitiveId id{visibility.instance[at], visibility.triangle[at]};
            if (id.instance == kSkyInstance) continue;
            hits.rows[j] = std::uint16_t(hits.rows[j] | 1u << i);
            if (id == last) continue;
            primitives.add(id.instance, id.triangle);
            last = id;
        }
    }
    return hits;
}

}  // namespace

CastCost cast_known_pixels(const scene::StaticScene& scene, const PinholeView& view, std::span<const TileRequest> tiles,
                           VisibilityBuffer& visibility) {
    FF_CHECK(visibility.width >= view.width && visibility.height >= view.height,
             "a buffer of {}x{} for a view of {}x{}", visibility.width, visibility.height, view.width, view.height);
    const beam::BeamView beam_view(view);
    CastCostSum sum;
    parallel_ranges(tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Task task;
        CastCost cost;
        for (std::size_t first = begin; first < end; first += kTilesTogether) {
            const std::size_t count = std::min(kTilesTogether, end - first);
            for (std::size_t t = 0; t < count; ++t) {
                task.primitives.start(std::span(task.ids).subspan(task.first[t]));
                task.hits[t] = collect(view, tiles[first + t], visibility, task.primitives);
                task.first[t + 1] = task.first[t] + task.primitives.ids().size();
            }
            fetch_triangles(scene, std::span(task.ids).first(task.first[count]), task.triangles);
            for (std::size_t t = 0; t < count; ++t) {
                const std::size_t known = task.first[t + 1] - task.first[t];
                TileRequest missed;
                cast_known_tile(scene, beam_view, task.hits[t], std::span(task.triangles).subspan(task.first[t], known),
                                visibility, missed);
                cost.rays += count_pixels(std::span(&task.hits[t], 1), view.width, view.height) -
                             count_pixels(std::span(&missed, 1), view.width, view.height);
                cost.triangles += known;
            }
        }
        sum.add(cost);
    });
    return sum.total();
}

}  // namespace ff::farfield
