// The horizon the plain way: every square of the finest level, in double, for the columns it is seen in.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/farfield/horizon.h"
#include "engine/farfield/horizon_azimuth.h"

namespace ff::farfield {
namespace {

/// Quasi-azimuth in turns, in double; see azimuth_turn.
double precise_turn(double x, double z) {
    const double ax = std::abs(x), az = std::abs(z), larger = std::max(ax, az);
    if (larger == 0.0) return 0.0;
    const double t = std::min(ax, az) / larger;
    double turn = t * (0.125 + double(kQuasiAngleBend) * (1.0 - t));
    if (ax > az) turn = 0.25 - turn;
    if (z > 0.0) turn = 0.5 - turn;
    return x < 0.0 ? 1.0 - turn : turn;
}

}  // namespace

void trace_horizon_reference(const scene::HeightGrid& grid, const WorldPos& eye, float near_distance_m,
                             std::span<double> tangents) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const int columns = int(tangents.size());
    std::fill(tangents.begin(), tangents.end(), -kInfinity);
    for (std::uint32_t row = 0; row < grid.size; ++row)
        for (std::uint32_t column = 0; column < grid.size; ++column) {
            const double rise = double(grid.heights[std::size_t(row) * grid.size + column]) + grid.base_y - eye.y;
            if (rise == -kInfinity) continue;
            const double low_x = grid.low_x + column * grid.square_m - eye.x, high_x = low_x + grid.square_m;
            const double low_z = grid.low_z + row * grid.square_m - eye.z, high_z = low_z + grid.square_m;
            if (std::hypot(std::max(-low_x, high_x), std::max(-low_z, high_z)) <= double(near_distance_m)) continue;

            const bool inside = low_x <= 0.0 && high_x >= 0.0 && low_z <= 0.0 && high_z >= 0.0;
            double start = 0.0, end = 1.0;
            if (!inside) {
                // Corners relative to the one in the middle of the turn: the square spans less than half of one.
                const double corner_x[4] = {low_x, high_x, high_x, low_x}, corner_z[4] = {low_z, low_z, high_z, high_z};
                const double middle = precise_turn(low_x + high_x, low_z + high_z);
                double low = 0.0, high = 0.0;
                for (int i = 0; i < 4; ++i) {
                    double offset = precise_turn(corner_x[i], corner_z[i]) - middle;
                    offset -= std::round(offset);
                    low = std::min(low, offset);
                    high = std::max(high, offset);
                }
                start = middle + low;
                end = middle + high;
            }
            const int first = int(std::floor(start * columns));
            const int count = std::min(columns, int(std::floor(end * columns)) - first + 1);
            for (int i = 0; i < count; ++i) {
                const int c = ((first + i) % columns + columns) % columns;
                // Sample the wedge at its borders and, where the square's corners lie inside it, at those.
                double nearest = kInfinity, farthest = 0.0;
                const auto sample = [&](double dx, double dz) {
                    double enter = 0.0, leave = kInfinity;
                    const auto slab = [&](double direction, double low, double high) {
                        if (std::abs(direction) < 1e-15) {
                            if (low > 0.0 || high < 0.0) leave = -1.0;
                            return;
                        }
                        const double a = low / direction, b = high / direction;
                        enter = std::max(enter, std::min(a, b));
                        leave = std::min(leave, std::max(a, b));
                    };
                    slab(dx, low_x, high_x);
                    slab(dz, low_z, high_z);
                    if (leave < enter) return;
                    nearest = std::min(nearest, enter);
                    farthest = std::max(farthest, leave);
                };
                for (int side = 0; side < 2; ++side) {
                    double dx, dz;
                    azimuth_direction(double(c + side) / columns, dx, dz);
                    sample(dx, dz);
                }
                // Axis directions inside the wedge: the square's faces are nearest there.
                for (int corner = 0; corner < 8; ++corner) {
                    const double x = corner < 4 ? (corner & 1 ? high_x : low_x)
                                                : (corner == 4   ? low_x
                                                   : corner == 5 ? high_x
                                                                 : 0.0);
                    const double z = corner < 4 ? (corner & 2 ? high_z : low_z)
                                                : (corner == 6   ? low_z
                                                   : corner == 7 ? high_z
                                                                 : 0.0);
                    if (x == 0.0 && z == 0.0) continue;
                    if (int(std::floor(precise_turn(x, z) * columns)) % columns != c) continue;
                    if (x < low_x || x > high_x || z < low_z || z > high_z) continue;
                    const double distance = std::hypot(x, z);
                    nearest = std::min(nearest, distance);
                    farthest = std::max(farthest, distance);
                }
                if (farthest == 0.0 && !inside) continue;
                nearest = std::max(inside ? 0.0 : nearest, double(near_distance_m));
                double tangent = rise > 0.0 ? (nearest > 0.0 ? rise / nearest : kInfinity) : rise / farthest;
                if (rise == 0.0) tangent = 0.0;
                tangents[std::size_t(c)] = std::max(tangents[std::size_t(c)], tangent);
            }
        }
}

}  // namespace ff::farfield
