// What the panorama's texels know of the light and the colour of pixels that others have answered.

#include <atomic>
#include <bit>
#include <optional>

#include "engine/core/jobs.h"
#include "engine/farfield/panorama_quads.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {
namespace {

constexpr std::size_t kTilesPerTask = 16;

/// What the texels of a quad that show this primitive say.
std::optional<std::uint8_t> light_of(const PanoramaMap& map, std::size_t quad, std::uint32_t instance,
                                     std::uint32_t triangle) {
    std::optional<std::uint8_t> light;
    for (const std::size_t at : {quad, quad + 1, quad + std::size_t(map.size), quad + std::size_t(map.size) + 1}) {
        if (map.visibility.instance[at] != instance || map.visibility.triangle[at] != triangle) continue;
        if (light && *light != map.light[at]) return std::nullopt;
        light = map.light[at];
    }
    return light;
}

}  // namespace

std::uint8_t* Panorama::light() {
    PanoramaMap& map = state_->map;
    if (map.light.empty()) {
        map.light = ZeroPageVector<std::uint8_t>(map.colors.size());
        populate_pages(map.light);
    }
    return map.light.data();
}

void Panorama::known_colors(const VisibilityBuffer& visibility, std::uint32_t* colors, int color_stride,
                            PixelMask& asked) {
    const State& s = *state_;
    parallel_ranges(s.edges.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const panorama::TileClasses& known = s.classes[t];
            const int x = s.edges[t].x, y = s.edges[t].y;
            TileMask& mask = asked.tile_of(s.edges[t]);
            if (!known.any || mask.count() == 0) continue;
            const std::int32_t* quad = known.quads.data();
            for (int j = 0; j < kTileSize; ++j)
                for (unsigned bits = unsigned(known.edge[j]) | known.noise[j]; bits != 0; bits &= bits - 1, ++quad) {
                    const int i = std::countr_zero(bits);
                    if (((mask.rows[j] >> i) & 1) == 0) continue;
                    const std::size_t at = visibility.index(x + i, y + j);
                    const std::uint32_t color =
                        mean_of_same(s.map, *quad, {visibility.instance[at], visibility.triangle[at]}).color;
                    if (color == 0) continue;
                    colors[std::size_t(y + j) * std::size_t(color_stride) + std::size_t(x + i)] = color;
                    mask.rows[j] = std::uint16_t(mask.rows[j] & ~(1u << i));
                }
        }
    });
}

std::uint64_t Panorama::known_light(const VisibilityBuffer& visibility, std::uint8_t* lit,
                                    std::vector<TileRequest>& tiles) {
    State& s = *state_;
    (void)light();
    const std::size_t columns = std::size_t(visibility.stride) / kTileSize;
    const auto tile_index = [&](const TileRequest& tile) {
        return std::size_t(tile.y) / kTileSize * columns + std::size_t(tile.x) / kTileSize;
    };
    s.wanted_at.assign(columns * (std::size_t(visibility.rows) / kTileSize), 0);
    for (std::size_t t = 0; t < s.edges.size(); ++t) s.wanted_at[tile_index(s.edges[t])] = std::uint32_t(t + 1);

    std::atomic<std::uint64_t> answered{0};
    parallel_ranges(tiles.size(), uneven_grain(tiles.size(), kTilesPerTask), [&](std::size_t begin, std::size_t end) {
        std::uint64_t count = 0;
        for (std::size_t t = begin; t < end; ++t) {
            TileRequest& tile = tiles[t];
            const std::uint32_t wanted = s.wanted_at[tile_index(tile)];
            if (wanted == 0 || !s.classes[wanted - 1].any) continue;
            const panorama::TileClasses& known = s.classes[wanted - 1];
            std::size_t kept = 0;
            for (std::size_t j = 0; j < kTileSize; ++j)
                for (std::uint32_t bits = known.edge[j] | known.noise[j]; bits != 0; bits &= bits - 1) {
                    const auto quad = std::size_t(known.quads[kept++]);
                    const int i = std::countr_zero(bits);
                    if (((tile.rows[j] >> i) & 1) == 0) continue;
                    const std::size_t at = visibility.index(tile.x + i, tile.y + int(j));
                    const auto light = light_of(s.map, quad, visibility.instance[at], visibility.triangle[at]);
                    if (!light) continue;
                    lit[at] = *light;
                    tile.rows[j] = std::uint16_t(tile.rows[j] & ~(1u << i));
                    ++count;
                }
        }
        answered.fetch_add(count, std::memory_order_relaxed);
    });
    std::erase_if(tiles, [](const TileRequest& tile) { return tile.is_empty(); });
    return answered.load(std::memory_order_relaxed);
}

}  // namespace ff::farfield
