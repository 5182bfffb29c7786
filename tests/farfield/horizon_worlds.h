#pragma once
// Height grids made in a line, with their max-mipmaps, for the horizon's tests and bench.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "engine/farfield/horizon.h"
#include "engine/scene/static_scene.h"

namespace ff::test {

struct OwnedHeightGrid {
    std::vector<float> heights;
    scene::HeightGrid grid;

    OwnedHeightGrid(std::uint32_t size, double low_x, double low_z, double square_m, double base_y) {
        std::size_t count = 0;
        for (std::uint32_t side = size; side > 0; side /= 2) count += std::size_t(side) * side;
        heights.assign(count, -std::numeric_limits<float>::infinity());
        grid = {size, low_x, low_z, square_m, base_y, heights};
    }
    float& at(std::uint32_t x, std::uint32_t z) { return heights[std::size_t(z) * grid.size + x]; }

    void make_mips() {
        std::size_t from = 0;
        for (std::uint32_t side = grid.size; side > 1; side /= 2) {
            const std::size_t to = from + std::size_t(side) * side;
            for (std::uint32_t z = 0; z < side / 2; ++z)
                for (std::uint32_t x = 0; x < side / 2; ++x) {
                    const float* block = &heights[from + std::size_t(2 * z) * side + 2 * x];
                    heights[to + std::size_t(z) * (side / 2) + x] =
                        std::max(std::max(block[0], block[1]), std::max(block[side], block[side + 1]));
                }
            from = to;
        }
        grid.heights = heights;
    }
    OwnedHeightGrid(const OwnedHeightGrid&) = delete;
    OwnedHeightGrid(OwnedHeightGrid&&) = default;
};

/// Rolling hills up to 400 m, rising outwards, with a town of blocks in the middle and thin spires here and there.
inline OwnedHeightGrid make_valley_grid(std::uint32_t size, double square_m, std::uint32_t seed) {
    OwnedHeightGrid world(size, -0.5 * size * square_m, -0.5 * size * square_m, square_m, 0.0);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (std::uint32_t z = 0; z < size; ++z)
        for (std::uint32_t x = 0; x < size; ++x) {
            const double px = (double(x) / size - 0.5) * 2.0, pz = (double(z) / size - 0.5) * 2.0;
            const double distance = std::sqrt(px * px + pz * pz);
            double height =
                300.0 * std::max(0.0, distance - 0.15) * (1.0 + 0.5 * std::sin(9 * px + seed) * std::cos(7 * pz)) +
                20.0 * std::sin(40.0 * px) * std::sin(33.0 * pz) + 3.0 * double(unit(random));
            if (distance < 0.12 && x % 6 != 0 && z % 5 != 0) height += 10.0 + 60.0 * double(unit(random));
            if (unit(random) < 1e-4f) height += 120.0;
            world.at(x, z) = float(height);
        }
    world.make_mips();
    return world;
}

/// Whether a ray meets the grid as solid bars from far below up to the height of each square.
/// @param near_m  what is horizontally nearer does not count
inline bool meets_bars(const OwnedHeightGrid& world, const WorldPos& eye, const DVec3& direction, double near_m) {
    const scene::HeightGrid& grid = world.grid;
    for (std::uint32_t z = 0; z < grid.size; ++z)
        for (std::uint32_t x = 0; x < grid.size; ++x) {
            const double height = double(grid.heights[std::size_t(z) * grid.size + x]) + grid.base_y;
            if (!std::isfinite(height)) continue;
            const double low[3] = {grid.low_x + x * grid.square_m, -1e9, grid.low_z + z * grid.square_m};
            const double high[3] = {low[0] + grid.square_m, height, low[2] + grid.square_m};
            double enter = near_m / std::max(1e-30, std::hypot(direction.x, direction.z)), leave = 1e30;
            for (int axis = 0; axis < 3; ++axis) {
                const double origin = eye[axis], step = direction[axis];
                if (step == 0.0) {
                    if (origin < low[axis] || origin > high[axis]) leave = -1.0;
                    continue;
                }
                const double a = (low[axis] - origin) / step, b = (high[axis] - origin) / step;
                enter = std::max(enter, std::min(a, b));
                leave = std::min(leave, std::max(a, b));
            }
            if (enter <= leave) return true;
        }
    return false;
}

/// Updates a skyline as a viewer does who walks to a view's place, by a step in any direction a frame, and swerves in
/// the last one.
/// @param world  scene or height grid
template <class World>
void walk_to(const World& world, const PinholeView& view, double step_m, std::uint32_t seed,
             farfield::HorizonMap& map) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> in(-1.0, 1.0);
    const auto any = [&] { return DVec3(in(engine), 0.3 * in(engine), in(engine)); };
    const DVec3 step = step_m * any(), swerve = 2.0 * step_m * any();
    PinholeView earlier = view;
    for (int left = int(engine() % 12); left > 0; --left) {
        earlier.position = view.position + swerve - double(left) * step;
        map.update(world, earlier);
    }
    map.update(world, view);
}

}  // namespace ff::test
