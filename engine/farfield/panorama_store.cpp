// Entering pixels that were cast for the screen, and forgetting what has changed.

#include <atomic>
#include <bit>
#include <glm/geometric.hpp>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {
namespace {

/// World direction of a texel, 1 along its face's axis.
DVec3 texel_direction(const PinholeView& face, int x, int row) {
    return DVec3(face.direction(x, row));
}

}  // namespace

void Panorama::store(const PinholeView& view, std::span<const TileRequest> tiles, const VisibilityBuffer& visibility,
                     std::span<const std::uint32_t> colors, int color_stride, const std::uint8_t* lit) {
    State& s = *state_;
    std::uint8_t* const texel_light = lit != nullptr ? light() : nullptr;
    FF_CHECK(s.record != kNeverTraced, "store before begin_frame");
    const int last = s.map.size - 1;
    const auto side = std::uint32_t(s.map.tiles_side);
    const auto texel_of = [&](int x, int y, float& axis) {
        const FacePoint p = face_point(view.direction(x, y));
        axis = p.axis;
        return std::pair(std::clamp(int(texel_x(s.map, p.a) + 0.5f), 0, last),
                         std::clamp(int(texel_y(s.map, p.b) + 0.5f), 0, last) + p.face * s.map.size);
    };
    // Two pixels may fall into one texel; tiles that touch take turns, so that the same one wins whoever runs first.
    for (std::uint32_t turn = 0; turn < 4; ++turn)
        parallel_ranges(tiles.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t t = begin; t < end; ++t) {
                const TileRequest& tile = tiles[t];
                if ((tile.x / kTileSize & 1u) + 2 * (tile.y / kTileSize & 1u) != turn) continue;
                for (int j = 0; j < kTileSize; ++j)
                    for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1) {
                        const int x = int(tile.x) + std::countr_zero(bits), y = int(tile.y) + j;
                        if (x >= view.width || y >= view.height) continue;
                        float axis = 1;
                        const auto [tx, ty] = texel_of(x, y, axis);
                        const std::size_t to = s.map.index(tx, ty), from = visibility.index(x, y);
                        s.map.visibility.instance[to] = visibility.instance[from];
                        s.map.visibility.triangle[to] = visibility.triangle[from];
                        s.map.visibility.depth[to] = visibility.depth[from] * axis;
                        s.map.colors[to] =
                            (colors[std::size_t(y) * std::size_t(color_stride) + std::size_t(x)] & 0x00FFFFFFu) |
                            kTexelMarked << 24;
                        s.map.records[to] = s.record;
                        if (lit != nullptr) texel_light[to] = lit[from];
                    }
            }
        });
    s.changed.clear();
    ++s.stamp;
    for (const TileRequest& tile : tiles) {
        const panorama::TileFootprint footprint = panorama::footprint_of(s.map, view, tile);
        if (footprint.face >= 0) {
            for (int ty = footprint.y0 / kTileSize; ty <= footprint.y1 / kTileSize; ++ty)
                for (int tx = footprint.x0 / kTileSize; tx <= footprint.x1 / kTileSize; ++tx)
                    s.mark(std::uint32_t(ty) * side + std::uint32_t(tx), s.changed);
            continue;
        }
        for (int j = 0; j < kTileSize; ++j)
            for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1) {
                float axis = 1;
                const auto [tx, ty] = texel_of(int(tile.x) + std::countr_zero(bits), int(tile.y) + j, axis);
                s.mark(std::uint32_t(ty / kTileSize) * side + std::uint32_t(tx / kTileSize), s.changed);
            }
    }
    for (const std::uint32_t tile : s.changed) s.map.tiles[tile].any_marked = true;
    s.refresh_changed();
}

std::uint64_t Panorama::invalidate(const DBox3& box, bool marked) {
    State& s = *state_;
    if (box.is_empty() || s.record == kNeverTraced) return 0;
    const auto side = std::size_t(s.map.tiles_side);
    const DVec3 center = box.center();
    const double radius = 0.5 * glm::length(box.extent());
    std::array<PinholeView, 6> faces;
    for (int face = 0; face < 6; ++face) faces[std::size_t(face)] = face_view(face);

    s.needs.resize(std::max(s.needs.size(), s.map.tiles.size()));
    std::atomic<std::uint64_t> forgotten{0};
    parallel_ranges(s.map.tiles.size(), 64, [&](std::size_t begin, std::size_t end) {
        std::uint64_t count = 0;
        for (std::size_t tile = begin; tile < end; ++tile) {
            s.needs[tile] = 0;
            const TexelTile& texels = s.map.tiles[tile];
            if (texels.record == kNeverTraced) continue;
            const int x0 = int(tile % side) * kTileSize, y0 = int(tile / side) * kTileSize;
            const PinholeView& face = faces[std::size_t(y0 / s.map.size)];
            const bool forget_marked = marked && texels.any_marked;
            if (!forget_marked && texels.record != kMixedRecords) {
                // The box's ball against the tile's cone.
                const DVec3 to = center - s.records[texels.record].position;
                const double distance = glm::length(to);
                const DVec3 middle = glm::normalize(texel_direction(face, x0 + 7, y0 + 7));
                const double cone =
                    std::acos(std::min(1.0, glm::dot(middle, glm::normalize(texel_direction(face, x0 - 1, y0 - 1)))));
                const double slack = 1.2 * cone + 1e-3;
                if (distance > radius && std::acos(std::clamp(glm::dot(to, middle) / distance, -1.0, 1.0)) >
                                             slack + std::asin(radius / distance))
                    continue;
            }
            for (int j = 0; j < kTileSize; ++j)
                for (int i = 0; i < kTileSize; ++i) {
                    const std::size_t at = s.map.index(x0 + i, y0 + j);
                    std::uint16_t& record = s.map.records[at];
                    if (record == kNeverTraced) continue;
                    const double depth = std::min(double(s.map.visibility.depth[at]), 1e9);
                    const bool forget = forget_marked && (s.map.colors[at] >> 24 & kTexelMarked) != 0;
                    if (!forget &&
                        !meets_segment(box, s.records[record].position, depth * texel_direction(face, x0 + i, y0 + j)))
                        continue;
                    record = kNeverTraced;
                    s.needs[tile] = 1;
                    ++count;
                }
        }
        forgotten.fetch_add(count, std::memory_order_relaxed);
    });
    s.changed.clear();
    for (std::size_t tile = 0; tile < s.map.tiles.size(); ++tile)
        if (s.needs[tile] != 0) s.changed.push_back(std::uint32_t(tile));
    s.refresh_changed();
    return forgotten.load(std::memory_order_relaxed);
}

}  // namespace ff::farfield
