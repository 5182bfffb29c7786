#include "engine/farfield/reproject_changes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/matrix.hpp>

#include "engine/core/jobs.h"

namespace ff::farfield::reprojection {
namespace {

constexpr double kFarthest = 1e9;     // metres: where the sky begins
constexpr double kDepthError = 1e-5;  // of a point's depth: it lies on a box that it misses by less
constexpr std::size_t kRowsPerTask = 16;

/// Pixels [x0, x1) x [y0, y1).
struct PixelRange {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] bool has(int x, int y, int size) const { return x < x1 && x + size > x0 && y < y1 && y + size > y0; }
};

/// Pixels whose rays may meet a box, one more on every side: all where it reaches behind the eye.
PixelRange range_of(const PinholeView& view, const DBox3& box) {
    const DMat3 camera_from_world = glm::transpose(DMat3(view.world_from_camera));
    double low_x = view.width, low_y = view.height, high_x = 0.0, high_y = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const DVec3 at((corner & 1) != 0 ? box.high.x : box.low.x, (corner & 2) != 0 ? box.high.y : box.low.y,
                       (corner & 4) != 0 ? box.high.z : box.low.z);
        const DVec3 camera = camera_from_world * (at - view.position);
        if (!(camera.z < -1e-6)) return {0, 0, view.width, view.height};
        const double x = (camera.x / -camera.z - double(view.u_first)) / double(view.u_step);
        const double y = (camera.y / -camera.z - double(view.v_first)) / double(view.v_step);
        low_x = std::min(low_x, x), high_x = std::max(high_x, x);
        low_y = std::min(low_y, y), high_y = std::max(high_y, y);
    }
    const auto pixel = [](double value, int size) { return int(std::clamp(value, 0.0, double(size))); };
    return {pixel(low_x - 1.0, view.width), pixel(low_y - 1.0, view.height), pixel(high_x + 2.0, view.width),
            pixel(high_y + 2.0, view.height)};
}

}  // namespace

void drop_points(std::span<const DBox3> changed, const PinholeView& last_view, const VisibilityBuffer& last,
                 ReprojectedPoints& points) {
    for (const DBox3& box : changed) {
        const PixelRange range = range_of(last_view, box);
        parallel_ranges(std::size_t(range.y1 - range.y0), kRowsPerTask, [&](std::size_t begin, std::size_t end) {
            for (int y = range.y0 + int(begin); y < range.y0 + int(end); ++y)
                for (int x = range.x0; x < range.x1; ++x) {
                    const std::size_t at = last.index(x, y);
                    if (last.instance[at] == kSkyInstance) continue;
                    const double depth = double(last.depth[at]);
                    const DVec3 point = last_view.position + depth * DVec3(last_view.direction(x, y));
                    if (distance_to(box, point) <= kDepthError * depth) points.target[at] = ReprojectedPoints::kOutside;
                }
        });
    }
}

TileMask pixels_behind(std::span<const DBox3> changed, const PinholeView& view, const TileRequest& answered,
                       const VisibilityBuffer& out) {
    TileMask mask;
    for (const DBox3& box : changed) {
        if (!range_of(view, box).has(answered.x, answered.y, kTileSize)) continue;
        for (int j = 0; j < kTileSize; ++j)
            for (std::uint32_t left = answered.rows[j]; left != 0; left &= left - 1) {
                const int i = std::countr_zero(left), x = answered.x + i, y = answered.y + j;
                const double depth = std::min(double(out.depth[out.index(x, y)]), kFarthest) * (1.0 + kDepthError);
                if (meets_segment(box, view.position, depth * DVec3(view.direction(x, y))))
                    mask.rows[j] = std::uint16_t(mask.rows[j] | 1u << i);
            }
    }
    return mask;
}

}  // namespace ff::farfield::reprojection
