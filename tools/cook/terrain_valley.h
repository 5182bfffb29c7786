#pragma once
// A made-up landscape: a broad valley with a river, between hills that grow to mountains.

#include <array>
#include <cstdint>

#include "tools/cook/terrain.h"

namespace ff::cook {

struct ValleySettings {
    std::uint64_t seed = 1;
    std::array<double, 2> size_m{60000.0, 60000.0};
    double spacing_m = 40.0;
    double relief_m = 1100.0;       ///< of the highest mountains above the floor
    double floor_width_m = 6000.0;  ///< of the level ground between the hills, north to south
    double water_m = -4.0;          ///< level of the river and the lakes; the floor lies a little above 0
};

/// The valley runs from west to east through the origin; its river keeps south of the middle.
/// Built from value noise with whole-number hashes and arithmetic alone: the same on every machine.
[[nodiscard]] HeightField make_valley(const ValleySettings& settings);

/// Smooth noise in [-1, 1], one bump per unit.
[[nodiscard]] double value_noise(std::uint64_t seed, double x, double z);
/// Octaves of it, each half the size and `gain` times the height of the one before; about [-1, 1].
[[nodiscard]] double fractal_noise(std::uint64_t seed, double x, double z, int octaves, double gain = 0.5);

/// A colour for natural ground, linear RGBA8: meadows, fields and woods below, rock where it is steep, scree and snow
/// high up. Snow begins about snow_line_m, bare rock at two thirds of it. For a texture whose mean colour has been
/// divided out.
[[nodiscard]] std::uint32_t natural_color(double x, double y, double z, const Vec3& normal, double water_m,
                                          double snow_line_m);

}  // namespace ff::cook
