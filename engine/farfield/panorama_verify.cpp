// Edges of the map, settled by the pixels' own rays without a search: what a pixel sees is nearly always what one of
// the four texels around it sees (P3's reprojection with a 2 x 2 neighbourhood, the viewer turning only).
//
// An edge tile has some thirty such pixels, and these name about ten primitives. What costs time is waiting for them:
// texels, then instances, then indices, then corners lie anywhere in memory. So a task takes each of these steps for
// several tiles at once.

#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/panorama_quads.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {
namespace {

constexpr std::size_t kTilesPerTask = 8;

/// Scratch of one task. Room for the primitives of two tiles at worst, of all where they are as few as usual; only
/// what is used of it is ever touched.
struct Task {
    PrimitiveSet primitives;
    std::array<PrimitiveId, 2 * PrimitiveSet::kCapacity> ids;
    std::array<KnownTriangle, 2 * PrimitiveSet::kCapacity> triangles;       // 96 KiB
    std::array<std::int32_t, kTilesPerTask * kTileSize * kTileSize> quads;  ///< of all tiles' edge pixels
    std::array<std::size_t, kTilesPerTask + 1> first_quad{}, first_id{};    ///< per tile
};

/// Appends the quads of the edges of a tile, row by row.
/// @return how many there are then
std::size_t collect_quads(const TileRequest& edges, const panorama::TileClasses& tile, std::span<std::int32_t> quads,
                          std::size_t count) {
    std::size_t kept = 0;
    for (std::size_t j = 0; j < kTileSize; ++j)
        for (std::uint32_t bits = tile.edge[j] | tile.noise[j]; bits != 0; bits &= bits - 1) {
            quads[count] = tile.quads[kept++];
            count += (edges.rows[j] >> std::countr_zero(bits)) & 1u;
        }
    return count;
}

void prefetch_texels(const PanoramaMap& map, std::int32_t quad) {
    for (const std::size_t at : {std::size_t(quad), std::size_t(quad) + std::size_t(map.size)}) {
        __builtin_prefetch(&map.visibility.instance[at]);
        __builtin_prefetch(&map.visibility.triangle[at]);
        __builtin_prefetch(&map.colors[at]);
    }
}

void prefetch_pixels(const TileRequest& tile, VisibilityBuffer& out) {
    for (int j = 0; j < kTileSize; ++j) {
        if (tile.rows[j] == 0) continue;
        const std::size_t at = out.index(tile.x, tile.y + j);
        __builtin_prefetch(&out.depth[at], 1);
        __builtin_prefetch(&out.instance[at], 1);
        __builtin_prefetch(&out.triangle[at], 1);
    }
}

/// Every near thing around was looked past: what is left is the farthest.
void show_farthest(const PanoramaMap& map, const TileRequest& tile, const TileRequest& missed,
                   std::span<const std::int32_t> quads, const PanoramaTarget& target) {
    const std::int32_t* row_quads = quads.data();
    for (int j = 0; j < kTileSize; row_quads += std::popcount(tile.rows[j]), ++j)
        for (std::uint32_t bits = missed.rows[j]; bits != 0; bits &= bits - 1) {
            const int i = std::countr_zero(bits);
            const auto texels = texels_of(row_quads[std::popcount(tile.rows[j] & ((1u << i) - 1u))], map.size);
            std::size_t farthest = texels[0];
            for (const std::size_t at : texels)
                if (map.visibility.depth[at] > map.visibility.depth[farthest]) farthest = at;
            target.colors[std::size_t(tile.y + j) * std::size_t(target.color_stride) + std::size_t(tile.x + i)] =
                map.colors[farthest] | 0xFF000000u;
        }
}

/// Pixels have the colour of the texels that show what their rays met: it was shaded less than a texel away.
/// @param marked  optional: those of marked texels are added
/// @return pixels whose texels do not, to be shaded
TileRequest show_same(const PanoramaMap& map, const TileRequest& tile, const TileRequest& missed,
                      std::span<const std::int32_t> quads, const VisibilityBuffer& met, const PanoramaTarget& target,
                      TileMask* marked) {
    TileRequest left{tile.x, tile.y, {}};
    const std::int32_t* quad = quads.data();
    for (int j = 0; j < kTileSize; ++j)
        for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1, ++quad) {
            const int i = std::countr_zero(bits);
            if (((missed.rows[j] >> i) & 1) != 0) continue;
            const std::size_t pixel = met.index(tile.x + i, tile.y + j);
            const auto [color, is_marked] = mean_of_same(map, *quad, {met.instance[pixel], met.triangle[pixel]});
            if (marked != nullptr) marked->rows[j] = std::uint16_t(marked->rows[j] | unsigned(is_marked) << i);
            if (color == 0)
                left.rows[j] = std::uint16_t(left.rows[j] | 1u << i);
            else
                target.colors[std::size_t(tile.y + j) * std::size_t(target.color_stride) + std::size_t(tile.x + i)] =
                    color;
        }
    return left;
}

}  // namespace

void Panorama::verify_edges(const scene::StaticScene& scene, const PinholeView& view, const PanoramaTarget& target,
                            VisibilityBuffer& out, PixelMask& left) {
    const State& s = *state_;
    FF_CHECK(left.width == view.width && left.height == view.height, "a mask of {} x {} for a view of {} x {}",
             left.width, left.height, view.width, view.height);
    const beam::BeamView beam_view(view);
    const VisibilityBuffer& map = s.map.visibility;
    parallel_ranges(s.edge_tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Task task;
        const std::size_t tiles = end - begin;
        const auto edges_of = [&](std::size_t t) -> const TileRequest& { return s.edges[s.edge_tiles[begin + t]]; };
        const auto quads_of = [&](std::size_t t) {
            return std::span(task.quads).subspan(task.first_quad[t], task.first_quad[t + 1] - task.first_quad[t]);
        };
        for (std::size_t t = 0; t < tiles; ++t) {
            const panorama::TileClasses& tile = s.classes[s.edge_tiles[begin + t]];
            __builtin_prefetch(&tile.edge);
            __builtin_prefetch(&tile.quads[0]);
            __builtin_prefetch(&tile.quads[16]);
            __builtin_prefetch(&edges_of(t));
        }
        for (std::size_t t = 0; t < tiles; ++t) {
            task.first_quad[t + 1] =
                collect_quads(edges_of(t), s.classes[s.edge_tiles[begin + t]], task.quads, task.first_quad[t]);
            for (const std::int32_t quad : quads_of(t)) prefetch_texels(s.map, quad);
        }
        for (std::size_t first = 0, last = 0; first < tiles; first = last) {
            // As many tiles as certainly have room.
            task.first_id[first] = 0;
            for (; last < tiles && task.first_id[last] + PrimitiveSet::kCapacity <= task.ids.size(); ++last) {
                task.primitives.start(std::span(task.ids).subspan(task.first_id[last]));
                for (const std::int32_t quad : quads_of(last))
                    for (const std::size_t at : texels_of(quad, s.map.size))
                        task.primitives.add(map.instance[at], map.triangle[at]);
                task.first_id[last + 1] = task.first_id[last] + task.primitives.ids().size();
                prefetch_pixels(edges_of(last), out);
            }
            fetch_triangles(scene, std::span(task.ids).first(task.first_id[last]), task.triangles);
            for (std::size_t t = first; t < last; ++t) {
                const TileRequest& tile = edges_of(t);
                const auto triangles =
                    std::span(task.triangles).subspan(task.first_id[t], task.first_id[t + 1] - task.first_id[t]);
                TileRequest missed;
                cast_known_tile(scene, beam_view, tile, triangles, out, missed);
                show_farthest(s.map, tile, missed, quads_of(t), target);
                TileMask& mask = left.tile_of(tile);
                TileMask* const marked = target.named != nullptr ? &target.named->tile_of(tile) : nullptr;
                const TileRequest unknown = show_same(s.map, tile, missed, quads_of(t), out, target, marked);
                for (int j = 0; j < kTileSize; ++j) mask.rows[j] = std::uint16_t(mask.rows[j] | unknown.rows[j]);
            }
        }
    });
}

}  // namespace ff::farfield
