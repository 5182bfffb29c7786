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

/// The outline of a box, of the part of it that lies before the eye.
PixelBox outline_of(const PinholeView& view, const DMat3& camera_from_world, const DBox3& box) {
    constexpr double kNearest = 1e-3;  // metres before the eye
    constexpr double kMarginPx = 1.0;  // for what rounding takes
    const double inf = std::numeric_limits<double>::infinity();
    PixelBox out{inf, inf, -inf, -inf};
    DVec3 corner[8];
    bool is_ahead[8];
    const auto add = [&](const DVec3& p) {
        const double x = (p.x / -p.z - double(view.u_first)) / double(view.u_step);
        const double y = (p.y / -p.z - double(view.v_first)) / double(view.v_step);
        out = {std::min(out.low_x, x - kMarginPx), std::min(out.low_y, y - kMarginPx),
               std::max(out.high_x, x + kMarginPx), std::max(out.high_y, y + kMarginPx)};
    };
    for (int k = 0; k < 8; ++k) {
        corner[k] =
            camera_from_world * (DVec3((k & 1) != 0 ? box.high.x : box.low.x, (k & 2) != 0 ? box.high.y : box.low.y,
                                       (k & 4) != 0 ? box.high.z : box.low.z) -
                                 view.position);
        is_ahead[k] = -corner[k].z > kNearest;
        if (is_ahead[k]) add(corner[k]);
    }
    // Edges that leave the part before the eye do so where they cross its plane.
    for (int k = 0; k < 8; ++k)
        for (const int axis : {1, 2, 4}) {
            if ((k & axis) != 0 || is_ahead[k] == is_ahead[k | axis]) continue;
            const DVec3 &a = corner[k], &b = corner[k | axis];
            DVec3 p = a + (b - a) * ((-kNearest - a.z) / (b.z - a.z));
            p.z = -kNearest;
            add(p);
        }
    return out;
}

}  // namespace

void MovingTiles::begin(const PinholeView& view) {
    view_ = view;
    camera_from_world_ = glm::inverse(DMat3(view.world_from_camera));
    columns_ = (view.width + farfield::kTileSize - 1) / farfield::kTileSize;
    rows_ = (view.height + farfield::kTileSize - 1) / farfield::kTileSize;
    touched_.assign(std::size_t(columns_) * std::size_t(rows_), 0);
}

void MovingTiles::add(const DBox3& bounds) {
    if (bounds.is_empty()) return;
    const auto tile_of = [](double pixel, int count) {
        return int(std::clamp(std::floor(pixel / farfield::kTileSize), -1.0, double(count)));
    };
    const PixelBox box = outline_of(view_, camera_from_world_, bounds);
    const int first_x = std::max(tile_of(box.low_x, columns_), 0);
    const int end_x = std::min(tile_of(box.high_x, columns_) + 1, columns_);
    const int end_y = std::min(tile_of(box.high_y, rows_) + 1, rows_);
    for (int y = std::max(tile_of(box.low_y, rows_), 0); y < end_y; ++y)
        for (int x = first_x; x < end_x; ++x) touched_[std::size_t(y) * std::size_t(columns_) + std::size_t(x)] = 1;
}

bool MovingTiles::has(const farfield::TileRequest& tile) const {
    const int x = tile.x / farfield::kTileSize, y = tile.y / farfield::kTileSize;
    return x < columns_ && y < rows_ && touched_[std::size_t(y) * std::size_t(columns_) + std::size_t(x)] != 0;
}

std::span<const farfield::TileRequest> MovingTiles::find(const PinholeView& view,
                                                         std::span<const scene::Instance> instances,
                                                         std::span<const farfield::TileRequest> tiles) {
    begin(view);
    for (const scene::Instance& instance : instances) add(instance.bounds);
    found_.clear();
    for (const farfield::TileRequest& tile : tiles)
        if (has(tile)) found_.push_back(tile);
    return found_;
}

}  // namespace ff::frame
