#include "tools/cook/terrain_valley.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "engine/core/jobs.h"
#include "tools/cook/mesh_builder.h"

namespace ff::cook {
namespace {

double smooth(double low, double high, double v) {
    const double t = std::clamp((v - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// In [-1, 1), from whole numbers: the finalizer of MurmurHash3 (Appleby 2011) over all three at once.
double corner_value(std::uint64_t seed, std::int64_t i, std::int64_t j) {
    std::uint64_t h = seed * 0x9E3779B97F4A7C15ull ^ std::uint64_t(i) * 0xC2B2AE3D27D4EB4Full ^
                      std::uint64_t(j) * 0x165667B19E3779F9ull;
    h = (h ^ (h >> 33)) * 0xFF51AFD7ED558CCDull;
    h = (h ^ (h >> 33)) * 0xC4CEB9FE1A85EC53ull;
    return double((h ^ (h >> 33)) >> 11) * 0x1.0p-52 - 1.0;
}

}  // namespace

double value_noise(std::uint64_t seed, double x, double z) {
    const double i = std::floor(x), j = std::floor(z);
    const double u = x - i, v = z - j;
    const double fu = u * u * u * (u * (u * 6 - 15) + 10), fv = v * v * v * (v * (v * 6 - 15) + 10);
    const auto corner = [&](double a, double b) {
        return corner_value(seed, std::int64_t(i + a), std::int64_t(j + b));
    };
    const double north = corner(0, 0) + fu * (corner(1, 0) - corner(0, 0));
    const double south = corner(0, 1) + fu * (corner(1, 1) - corner(0, 1));
    return north + fv * (south - north);
}

double fractal_noise(std::uint64_t seed, double x, double z, int octaves, double gain) {
    double sum = 0, total = 0, weight = 1;
    for (int o = 0; o < octaves; ++o) {
        sum += weight * value_noise(seed + std::uint64_t(o), x, z);
        total += weight;
        weight *= gain;
        // Turned by about 37 degrees from octave to octave, so that the lattice does not show.
        const double turned = 1.6 * x - 1.2 * z;
        z = 1.2 * x + 1.6 * z + 11.3;
        x = turned + 7.1;
    }
    return sum / total;
}

HeightField make_valley(const ValleySettings& s) {
    HeightField field;
    field.columns = int(std::lround(s.size_m[0] / s.spacing_m)) + 1;
    field.rows = int(std::lround(s.size_m[1] / s.spacing_m)) + 1;
    field.spacing_x = s.size_m[0] / (field.columns - 1), field.spacing_z = s.size_m[1] / (field.rows - 1);
    field.low_x = -0.5 * s.size_m[0], field.low_z = -0.5 * s.size_m[1];
    field.heights.resize(std::size_t(field.columns) * field.rows);
    const double half = 0.5 * s.floor_width_m;
    parallel_ranges(std::size_t(field.rows), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j)
            for (int i = 0; i < field.columns; ++i) {
                const double x = field.low_x + i * field.spacing_x, z = field.low_z + double(j) * field.spacing_z;
                // The valley bends away from the origin, and widens towards the lake in the east.
                const double bend =
                    5000.0 * value_noise(s.seed + 11, x / 14000.0, 0.5) * smooth(3000, 12000, std::abs(x));
                const double from_axis = std::abs(z - bend) + 900.0 * fractal_noise(s.seed + 12, x / 2600, z / 2600, 3);
                const double rise = smooth(half, half + 9000.0, from_axis);
                const double foothill = smooth(half - 300.0, half + 2500.0, from_axis);
                const double ridges = 1.0 - std::abs(fractal_noise(s.seed + 13, x / 7000, z / 7000, 5, 0.42)) * 2.2;
                const double rolling = 0.5 + 0.5 * fractal_noise(s.seed + 14, x / 2200, z / 2200, 4);
                double y = 3.0 + 2.0 * fractal_noise(s.seed + 15, x / 900, z / 900, 3) + 170.0 * foothill * rolling +
                           s.relief_m * rise * std::max(0.0, 0.35 + 0.65 * ridges);
                // The river, 70 m wide, between the town and the southern hills.
                const double river_z = bend + half * 0.8 + 350.0 * value_noise(s.seed + 16, x / 1900, 3.5);
                const double from_river = std::abs(z - river_z);
                const double bank = 1.0 - smooth(30.0, 130.0, from_river);
                y += (s.water_m - 4.0 - y) * bank;
                // A lake down the valley.
                const double lx = (x - 11500.0) / 3600.0, lz = (z - bend - 200.0) / 1700.0;
                const double shore =
                    1.0 - smooth(0.7, 1.15, lx * lx + lz * lz + 0.3 * fractal_noise(s.seed + 17, x / 900, z / 900, 3));
                y += (s.water_m - 12.0 - y) * shore;
                field.heights[j * std::size_t(field.columns) + std::size_t(i)] = float(y);
            }
    });
    return field;
}

std::uint32_t natural_color(double x, double y, double z, const Vec3& normal, double water_m, double snow_line_m) {
    const Vec3 meadow(0.15f, 0.22f, 0.06f), dry(0.30f, 0.26f, 0.10f), wood(0.05f, 0.09f, 0.03f);
    const Vec3 rock(0.26f, 0.25f, 0.24f), snow(0.86f, 0.88f, 0.92f), sand(0.40f, 0.35f, 0.24f);
    const auto mix = [](const Vec3& a, const Vec3& b, double t) {
        return glm::mix(a, b, float(std::clamp(t, 0.0, 1.0)));
    };
    Vec3 color = mix(meadow, dry, 0.5 + 0.9 * fractal_noise(101, x / 600, z / 600, 3));
    color = mix(color, wood, smooth(0.0, 0.25, fractal_noise(102, x / 1100, z / 1100, 4)) * smooth(15, 60, y));
    const double steep = 1.0 - double(normal.y);
    color = mix(color, rock, smooth(0.10, 0.24, steep + 0.05 * value_noise(103, x / 90, z / 90)));
    color =
        mix(color, rock, smooth(0.6 * snow_line_m, 0.85 * snow_line_m, y + 120 * value_noise(104, x / 500, z / 500)));
    color = mix(color, snow,
                smooth(snow_line_m - 80, snow_line_m + 80, y + 110 * value_noise(105, x / 350, z / 350)) *
                    smooth(0.34, 0.18, steep));
    color = mix(color, sand, smooth(water_m + 2.5, water_m + 0.5, y));
    return pack_color(color * float(0.94 + 0.12 * value_noise(106, x / 40, z / 40)));
}

}  // namespace ff::cook
