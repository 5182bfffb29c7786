#include "engine/frame/moving_tiles.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

namespace ff::frame {
namespace {

/// Pixels [low, high] that a box covers; empty where high < low.
struct PixelBox {
    double low_x = 0, low_y = 0, high_x = -1, high_y = -1;
};

/// The outline of a box's corners. A box that reaches behind the eye may be anywhere.
PixelBox outline_of(const PinholeView& view, const DMat3& camera_from_world, const DBox3& box) {
    constexpr double kNearest = 1e-3;  // metres before the eye
    constexpr double kMarginPx = 1.0;  // for what rounding takes
    const double inf = std::numeric_limits<double>::infinity();
    PixelBox out{inf, inf, -inf, -inf};
    int behind = 0;
    for (int k = 0; k < 8; ++k) {
        const DVec3 corner((k & 1) != 0 ? box.high.x : box.low.x, (k & 2) != 0 ? box.high.y : box.low.y,
                           (k & 4) != 0 ? box.high.z : box.low.z);
        const DVec3 p = camera_from_world * (corner - view.position);
        if (!(-p.z > kNearest)) {
            ++behind;
            continue;
        }
        const double x = (p.x / -p.z - double(view.u_first)) / double(view.u_step);
        const double y = (p.y / -p.z - double(view.v_first)) / double(view.v_step);
        out = {std::min(out.low_x, x - kMarginPx), std::min(out.low_y, y - kMarginPx),
               std::max(out.high_x, x + kMarginPx), std::max(out.high_y, y + kMarginPx)};
    }
    if (behind == 8) return {};
    if (behind > 0) return {0.0, 0.0, double(view.width), double(view.height)};
    return out;
}

}  // namespace

std::span<const farfield::TileRequest> MovingTiles::find(const PinholeView& view,
                                                         std::span<const scene::Instance> instances,
                                                         std::span<const farfield::TileRequest> tiles) {
    const int columns = (view.width + farfield::kTileSize - 1) / farfield::kTileSize;
    const int rows = (view.height + farfield::kTileSize - 1) / farfield::kTileSize;
    touched_.assign(std::size_t(columns) * std::size_t(rows), 0);
    found_.clear();
    const DMat3 camera_from_world = glm::inverse(DMat3(view.world_from_camera));
    const auto tile_of = [](double pixel, int count) {
        return int(std::clamp(std::floor(pixel / farfield::kTileSize), -1.0, double(count)));
    };
    for (const scene::Instance& instance : instances) {
        if (instance.bounds.is_empty()) continue;
        const PixelBox box = outline_of(view, camera_from_world, instance.bounds);
        const int first_x = std::max(tile_of(box.low_x, columns), 0);
        const int end_x = std::min(tile_of(box.high_x, columns) + 1, columns);
        const int end_y = std::min(tile_of(box.high_y, rows) + 1, rows);
        for (int y = std::max(tile_of(box.low_y, rows), 0); y < end_y; ++y)
            for (int x = first_x; x < end_x; ++x) touched_[std::size_t(y) * std::size_t(columns) + std::size_t(x)] = 1;
    }
    for (const farfield::TileRequest& tile : tiles) {
        const int x = tile.x / farfield::kTileSize, y = tile.y / farfield::kTileSize;
        if (x < columns && y < rows && touched_[std::size_t(y) * std::size_t(columns) + std::size_t(x)] != 0)
            found_.push_back(tile);
    }
    return found_;
}

}  // namespace ff::frame
