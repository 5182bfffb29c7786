#include "engine/farfield/moving_shadow.h"

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>
#include <limits>

namespace ff::farfield {

bool may_be_shaded(const PinholeView& view, const VisibilityBuffer& visibility, const TileRequest& tile,
                   std::span<const MovingSphere> moving, const Vec3& to_sun) {
    if (moving.empty()) return false;
    float near = std::numeric_limits<float>::infinity(), far = 0.0f;
    for (int j = 0; j < kTileSize; ++j) {
        const std::size_t first = visibility.index(tile.x, tile.y + j);
        for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1) {
            const std::size_t at = first + std::size_t(std::countr_zero(bits));
            if (visibility.instance[at] >= kUnresolved) continue;
            near = std::min(near, visibility.depth[at]);
            far = std::max(far, visibility.depth[at]);
        }
    }
    if (!(near <= far)) return false;
    // The ball round the corners of what the tile sees.
    DVec3 corners[8], centre(0.0);
    for (int k = 0; k < 8; ++k) {
        const int x = tile.x + (k & 1) * kTileSize, y = tile.y + (k >> 1 & 1) * kTileSize;
        const DVec3 ray = DMat3(view.world_from_camera) *
                          DVec3(double(x) * view.u_step + view.u_first, double(y) * view.v_step + view.v_first, -1.0);
        corners[k] = ray * double(k < 4 ? near : far);
        centre += corners[k] / 8.0;
    }
    double radius = 0.0;
    for (const DVec3& corner : corners) radius = std::max(radius, glm::length(corner - centre));
    const DVec3 sun(to_sun);
    return std::any_of(moving.begin(), moving.end(), [&](const MovingSphere& sphere) {
        const DVec3 to_sphere = sphere.center - view.position - centre;
        const double along = std::max(0.0, glm::dot(to_sphere, sun));  // shadows fall away from the sun
        return glm::length(to_sphere - along * sun) <= radius + sphere.radius;
    });
}

}  // namespace ff::farfield
