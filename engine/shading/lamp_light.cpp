#include "engine/shading/lamp_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace ff::shading {

int find_tile_lamps(std::span<const LampLight> lamps, const PinholeView& view,
                    const farfield::VisibilityBuffer& visibility, const farfield::TileRequest& tile,
                    std::array<std::uint16_t, kMaxTileLamps>& out) {
    if (lamps.empty()) return 0;
    float nearest = std::numeric_limits<float>::infinity(), farthest = 0.0f;
    for (int row = 0; row < farfield::kTileSize; ++row) {
        if (tile.rows[row] == 0) continue;
        const float* depth = visibility.depth.data() + visibility.index(tile.x, tile.y + row);
        for (unsigned i = 0; i < unsigned(farfield::kTileSize); ++i) {
            if (((tile.rows[row] >> i) & 1u) == 0 || !std::isfinite(depth[i])) continue;
            nearest = std::min(nearest, depth[i]);
            farthest = std::max(farthest, depth[i]);
        }
    }
    if (nearest > farthest) return 0;

    // A box around the part of the tile's pyramid between the depths.
    Vec3 low(std::numeric_limits<float>::infinity()), high = -low;
    for (const int dx : {0, farfield::kTileSize})
        for (const int dy : {0, farfield::kTileSize}) {
            const Vec3 ray = view.world_from_camera * Vec3(float(tile.x + dx) * view.u_step + view.u_first,
                                                           float(tile.y + dy) * view.v_step + view.v_first, -1.0f);
            for (const float depth : {nearest, farthest}) {
                low = glm::min(low, depth * ray);
                high = glm::max(high, depth * ray);
            }
        }
    int count = 0;
    for (std::size_t i = 0; i < lamps.size() && count < kMaxTileLamps; ++i) {
        const Vec3 beside = lamps[i].position - glm::clamp(lamps[i].position, low, high);
        if (glm::dot(beside, beside) < lamps[i].radius_m * lamps[i].radius_m)
            out[std::size_t(count++)] = std::uint16_t(i);
    }
    return count;
}

}  // namespace ff::shading
