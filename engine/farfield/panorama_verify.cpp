// Edges of the map, settled by the pixels' own rays without a search: what a pixel sees is nearly always what one of
// the four texels around it sees (P3's reprojection with a 2 x 2 neighbourhood, the viewer turning only).

#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/known_primitives.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {

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
    parallel_ranges(s.edges.size(), 8, [&](std::size_t begin, std::size_t end) {
        PrimitiveSet primitives;
        std::array<std::int32_t, kTileSize * kTileSize> quads;
        for (std::size_t t = begin; t < end; ++t) {
            const TileRequest& tile = s.edges[t];
            panorama::find_quads(job, tile, quads);
            primitives.clear();
            for (int j = 0; j < kTileSize; ++j)
                for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1) {
                    const auto quad = std::size_t(quads[std::size_t(j * kTileSize + std::countr_zero(bits))]);
                    for (const std::size_t at : {quad, quad + 1, quad + row_step, quad + row_step + 1})
                        primitives.add(map.instance[at], map.triangle[at]);
                }
            TileRequest missed;
            cast_known_tile(scene, beam_view, tile, primitives.ids(), out, missed);
            TileMask& mask = verified.tiles[std::size_t(tile.y / kTileSize) * std::size_t(verified.tiles_x) +
                                            std::size_t(tile.x / kTileSize)];
            for (int j = 0; j < kTileSize; ++j) {
                for (std::uint32_t bits = missed.rows[j]; bits != 0; bits &= bits - 1) {
                    // Every near thing around was looked past: what is left is the farthest.
                    const int i = std::countr_zero(bits);
                    const auto quad = std::size_t(quads[std::size_t(j * kTileSize + i)]);
                    std::size_t farthest = quad;
                    for (const std::size_t at : {quad + 1, quad + row_step, quad + row_step + 1})
                        if (map.depth[at] > map.depth[farthest]) farthest = at;
                    target
                        .colors[std::size_t(tile.y + j) * std::size_t(target.color_stride) + std::size_t(tile.x + i)] =
                        s.map.colors[farthest] | 0xFF000000u;
                }
                mask.rows[j] = std::uint16_t(mask.rows[j] | (tile.rows[j] & ~missed.rows[j]));
            }
        }
    });
}

}  // namespace ff::farfield
