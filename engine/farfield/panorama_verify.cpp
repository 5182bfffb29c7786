// Edges of the map, settled by the pixels' own rays without a search: what a pixel sees is nearly always what one of
// the four texels around it sees (P3's reprojection with a 2 x 2 neighbourhood, the viewer turning only).

#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/known_primitives.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {
namespace {

constexpr std::size_t kTilesPerTask = 8;

/// Scratch of one task. Room for the primitives of two tiles at worst, of all where they are as few as usual; only
/// what is used of it is ever touched.
struct Task {
    PrimitiveSet primitives;
    std::array<PrimitiveId, 2 * PrimitiveSet::kCapacity> ids;
    std::array<KnownTriangle, 2 * PrimitiveSet::kCapacity> triangles;                  // 96 KiB
    std::array<std::array<std::int32_t, kTileSize * kTileSize>, kTilesPerTask> quads;  ///< of the pixels asked for
    std::array<std::size_t, kTilesPerTask> quad_counts;
};

template <class Visit>
void visit_pixels(const TileRequest& tile, Visit&& visit) {
    for (int j = 0; j < kTileSize; ++j)
        for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1) visit(j, std::countr_zero(bits));
}

}  // namespace

void Panorama::verify_edges(const scene::StaticScene& scene, const PinholeView& view, const PanoramaTarget& target,
                            VisibilityBuffer& out, PixelMask& verified) {
    const State& s = *state_;
    FF_CHECK(verified.width == view.width && verified.height == view.height, "a mask of {} x {} for a view of {} x {}",
             verified.width, verified.height, view.width, view.height);
    panorama::LookupJob job;
    job.map = &s.map;
    job.view = &view;
    const beam::BeamView beam_view(view);
    const VisibilityBuffer& map = s.map.visibility;
    const auto row_step = std::size_t(s.map.size);
    parallel_ranges(s.edges.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Task task;
        // All quads first: what they name is then on its way from memory.
        std::array<std::int32_t, kTileSize * kTileSize> quads;
        for (std::size_t t = begin; t < end; ++t) {
            panorama::find_quads(job, s.edges[t], quads);
            std::size_t count = 0;
            auto& of_tile = task.quads[t - begin];
            visit_pixels(s.edges[t], [&](int j, int i) {
                const std::int32_t quad = quads[std::size_t(j * kTileSize + i)];
                of_tile[count++] = quad;
                for (const std::size_t at : {std::size_t(quad), std::size_t(quad) + row_step}) {
                    __builtin_prefetch(&map.instance[at]);
                    __builtin_prefetch(&map.triangle[at]);
                }
            });
            task.quad_counts[t - begin] = count;
        }
        for (std::size_t t = begin; t < end;) {
            // As many tiles as certainly have room.
            const std::size_t first = t;
            std::array<std::size_t, kTilesPerTask + 1> first_id{};
            std::size_t ids = 0;
            for (; t < end && ids + PrimitiveSet::kCapacity <= task.ids.size(); ++t) {
                task.primitives.start(std::span(task.ids).subspan(ids));
                for (std::size_t q = 0; q < task.quad_counts[t - begin]; ++q) {
                    const auto quad = std::size_t(task.quads[t - begin][q]);
                    for (const std::size_t at : {quad, quad + 1, quad + row_step, quad + row_step + 1})
                        task.primitives.add(map.instance[at], map.triangle[at]);
                }
                ids += task.primitives.ids().size();
                first_id[t - first + 1] = ids;
            }
            fetch_triangles(scene, std::span(task.ids).first(ids), task.triangles);
            for (std::size_t u = first; u < t; ++u) {
                const TileRequest& tile = s.edges[u];
                const std::size_t from = first_id[u - first], to = first_id[u - first + 1];
                TileRequest missed;
                cast_known_tile(scene, beam_view, tile, std::span(task.triangles).subspan(from, to - from), out,
                                missed);
                TileMask& mask = verified.tiles[std::size_t(tile.y / kTileSize) * std::size_t(verified.tiles_x) +
                                                std::size_t(tile.x / kTileSize)];
                for (int j = 0; j < kTileSize; ++j)
                    mask.rows[j] = std::uint16_t(mask.rows[j] | (tile.rows[j] & ~missed.rows[j]));
                // Every near thing around was looked past: what is left is the farthest.
                std::size_t q = 0;
                visit_pixels(tile, [&](int j, int i) {
                    const auto quad = std::size_t(task.quads[u - begin][q++]);
                    if (((missed.rows[j] >> i) & 1) == 0) return;
                    std::size_t farthest = quad;
                    for (const std::size_t at : {quad + 1, quad + row_step, quad + row_step + 1})
                        if (map.depth[at] > map.depth[farthest]) farthest = at;
                    target
                        .colors[std::size_t(tile.y + j) * std::size_t(target.color_stride) + std::size_t(tile.x + i)] =
                        s.map.colors[farthest] | 0xFF000000u;
                });
            }
        }
    });
}

}  // namespace ff::farfield
