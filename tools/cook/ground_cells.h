#pragma once
// Which cells of a horizontal grid a triangle covers, and between which heights in each.
// Based on: Mononen, Recast Navigation, 2009: a triangle is cut by the rows of the grid, each strip by the columns.

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/math/types.h"

namespace ff::cook {

/// A rectangle of cells, high ends excluded.
struct CellRect {
    int x0 = 0, z0 = 0, x1 = 0, z1 = 0;
};

namespace detail {

struct CellPolygon {
    DVec3 corners[12];  // a triangle cut by four lines has at most 7; left unset
    int count = 0;
};

// Cuts at coordinate `axis` = at: what lies below goes to `below`, the rest to `above`. Both get the cut edge.
inline void cut(const CellPolygon& in, int axis, double at, CellPolygon& below, CellPolygon& above) {
    below.count = above.count = 0;
    for (int i = 0, j = in.count - 1; i < in.count; j = i++) {
        const DVec3 &a = in.corners[std::size_t(j)], &b = in.corners[std::size_t(i)];
        const double da = a[axis] - at, db = b[axis] - at;
        if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) {
            const DVec3 middle = a + (b - a) * (da / (da - db));
            if (below.count < 12) below.corners[std::size_t(below.count++)] = middle;
            if (above.count < 12) above.corners[std::size_t(above.count++)] = middle;
        }
        if (db <= 0.0 && below.count < 12) below.corners[std::size_t(below.count++)] = b;
        if (db >= 0.0 && above.count < 12) above.corners[std::size_t(above.count++)] = b;
    }
}

}  // namespace detail

/// Calls visit(x, z, low, high) for each cell of `rect` that the triangle touches, row by row.
/// @param corners  x and z in cells from the grid's corner, y in metres; finite
template <class Visit>
void for_each_cell(const std::array<DVec3, 3>& corners, const CellRect& rect, Visit&& visit) {
    using detail::CellPolygon;
    const auto [min_x, max_x] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
    const auto [min_z, max_z] = std::minmax({corners[0].z, corners[1].z, corners[2].z});
    if (max_x < rect.x0 || min_x >= rect.x1 || max_z < rect.z0 || min_z >= rect.z1) return;
    const auto first = [](double low, int bound) { return low <= bound ? bound : static_cast<int>(std::floor(low)); };
    const auto last = [](double high, int end) { return high >= end ? end - 1 : static_cast<int>(std::floor(high)); };
    const int x_begin = first(min_x, rect.x0), x_last = last(max_x, rect.x1);
    const int z_begin = first(min_z, rect.z0), z_last = last(max_z, rect.z1);
    if (x_begin == x_last && z_begin == z_last && min_x >= x_begin && min_z >= z_begin && max_x <= x_begin + 1 &&
        max_z <= z_begin + 1) {
        const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
        visit(x_begin, z_begin, low, high);
        return;
    }
    CellPolygon buffers[4];
    CellPolygon *rest = &buffers[0], *row = &buffers[1], *cell = &buffers[2], *next = &buffers[3];
    rest->count = 3;
    std::copy(corners.begin(), corners.end(), rest->corners);
    detail::cut(*rest, 2, z_begin, *row, *next);
    std::swap(rest, next);
    for (int z = z_begin; z <= z_last && rest->count > 0; ++z) {
        detail::cut(*rest, 2, z + 1, *row, *next);
        std::swap(rest, next);
        if (row->count == 0) continue;
        double row_min = row->corners[0].x, row_max = row_min;
        for (int i = 1; i < row->count; ++i) {
            row_min = std::min(row_min, row->corners[std::size_t(i)].x);
            row_max = std::max(row_max, row->corners[std::size_t(i)].x);
        }
        if (row_max < rect.x0 || row_min >= rect.x1) continue;
        const int begin = first(row_min, rect.x0), end = last(row_max, rect.x1);
        detail::cut(*row, 0, begin, *cell, *next);
        std::swap(row, next);
        for (int x = begin; x <= end && row->count > 0; ++x) {
            detail::cut(*row, 0, x + 1, *cell, *next);
            std::swap(row, next);
            if (cell->count == 0) continue;
            double low = cell->corners[0].y, high = low;
            for (int i = 1; i < cell->count; ++i) {
                low = std::min(low, cell->corners[std::size_t(i)].y);
                high = std::max(high, cell->corners[std::size_t(i)].y);
            }
            visit(x, z, low, high);
        }
    }
}

}  // namespace ff::cook
