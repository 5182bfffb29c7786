#include "engine/farfield/moving_shadow.h"

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>
#include <limits>

namespace ff::farfield {
namespace {

/// Whether the ball may stand between the sun and a ball of `radius` round a point, both relative to the same origin.
bool may_shade(const DVec3& to_sphere, double radii, const DVec3& sun) {
    const double along = std::max(0.0, glm::dot(to_sphere, sun));  // shadows fall away from the sun
    const DVec3 beside = to_sphere - along * sun;
    return glm::dot(beside, beside) <= radii * radii;
}

/// The same for each requested pixel's own point: a tile that sees the foreground and the distance has a large ball
/// round what it sees, and most shadows in that fall on nothing that it does see.
bool shades_a_pixel(const PinholeView& view, const VisibilityBuffer& visibility, const TileRequest& tile,
                    const MovingSphere& sphere, const DVec3& sun) {
    const DVec3 center = sphere.center - view.position;
    // Neighbours' light is taken for a pixel's, so two pixels beside the shadow count as in it.
    const double margin = 2.5 * double(view.pixel_angle());
    const DVec3 right(DVec3(view.world_from_camera[0]) * double(view.u_step));
    for (int j = 0; j < kTileSize; ++j) {
        const std::size_t first = visibility.index(tile.x, tile.y + j);
        const DVec3 left(view.direction(tile.x, tile.y + j));
        for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1) {
            const int i = std::countr_zero(bits);
            const std::size_t at = first + std::size_t(i);
            if (visibility.instance[at] >= kUnresolved) continue;
            const double depth = double(visibility.depth[at]);
            const DVec3 point = (left + double(i) * right) * depth;
            const double beside = margin * depth;
            if (!may_shade(center - point, sphere.radius + beside, sun)) continue;
            if (sphere.box.is_empty()) return true;
            const DBox3 box{sphere.box.low - beside, sphere.box.high + beside};
            const DVec3 from = view.position + point;
            const double beyond = 2.0 * sphere.radius + glm::length(center - point);
            if (meets_segment(box, from, sun * beyond)) return true;
        }
    }
    return false;
}

}  // namespace

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
        return may_shade(sphere.center - view.position - centre, radius + sphere.radius, sun) &&
               shades_a_pixel(view, visibility, tile, sphere, sun);
    });
}

}  // namespace ff::farfield
