#include "engine/shading/atmosphere.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "engine/math/types.h"

namespace ff::shading {
namespace {

using DVec2 = glm::dvec2;

constexpr double kGroundRadiusM = 6360e3, kTopRadiusM = 6420e3;
/// Per metre at height 0, at 615, 535 and 445 nm, the middles of sRGB's primaries: the sources' values at 550 nm,
/// Rayleigh by the inverse fourth power, ozone in proportion to the Chappuis band's cross sections. (At the sources'
/// 680, 550 and 440 nm ozone takes most of green, and dusk is purple.)
const DVec3 kRayleigh(8.67e-6, 15.14e-6, 31.6e-6);
const DVec3 kOzone(2.60e-6, 1.50e-6, 0.090e-6);
constexpr double kGreenRayleigh = 13.558e-6;  ///< at 550 nm, of which turbidity speaks
constexpr double kOzoneMiddleM = 25e3, kOzoneHalfM = 15e3;
/// Of haze, the share of what it takes from a ray that it scatters.
constexpr double kMieAlbedo = 0.9;
/// Single scattering over all scattering of a clear day's sky, roughly.
constexpr double kMoreScattering = 2.2;
/// Sun's angular radius, radians.
constexpr double kSunRadius = 0.00465;
/// Full moon and stars on level ground, over the sun above the air.
constexpr double kNightIlluminance = 1.5e-6;
const DVec3 kNightTint(0.62, 0.82, 1.25);
/// Share of it that comes from the whole sky; the rest is the moon's, which is not drawn.
constexpr double kNightSky = 0.25;
/// Ground's mean albedo, which light from below has.
const DVec3 kGroundAlbedo(0.21, 0.19, 0.15);
/// The eye's adaptation: what remains of a difference in illuminance is its power 1 + this.
constexpr double kAdaptation = -0.8;
/// So that level ground in the sun at noon is as bright as by the default daylight.
constexpr double kExposure = 4.1;

constexpr int kViewSteps = 32, kSunSteps = 10;

struct Air {
    DVec3 rayleigh;  ///< extinction at height 0
    double mie;

    struct Density {
        double rayleigh, mie, ozone;
    };
    static Density density(double height_m) {
        return {std::exp(-height_m / double(kRayleighHeightM)), std::exp(-height_m / double(kMieHeightM)),
                std::max(0.0, 1.0 - std::abs(height_m - kOzoneMiddleM) / kOzoneHalfM)};
    }
    [[nodiscard]] DVec3 extinction(const Density& d) const {
        return rayleigh * d.rayleigh + DVec3(mie * d.mie) + kOzone * d.ozone;
    }
};

/// Way to a sphere around the planet's middle from a point inside it.
double way_out(const DVec2& from, const DVec2& along, double radius_m) {
    const double b = glm::dot(from, along);
    return -b + std::sqrt(std::max(0.0, b * b - glm::dot(from, from) + radius_m * radius_m));
}

bool hits_ground(const DVec2& from, const DVec2& along) {
    const double b = glm::dot(from, along);
    return b < 0.0 && glm::dot(from, from) - b * b < kGroundRadiusM * kGroundRadiusM;
}

/// Share of a ray's light that leaves the air. Points and directions lie in the plane of zenith and sun.
DVec3 transmittance(const Air& air, const DVec2& from, const DVec2& along) {
    if (hits_ground(from, along)) return DVec3(0.0);
    const double way = way_out(from, along, kTopRadiusM);
    DVec3 depth(0.0);
    for (int i = 0; i < kSunSteps; ++i) {
        // Steps grow: the air is densest where the ray begins.
        const double t0 = double(i) / kSunSteps, t1 = double(i + 1) / kSunSteps;
        const double at = way * 0.5 * (t0 * t0 + t1 * t1), step = way * (t1 * t1 - t0 * t0);
        const double height = glm::length(from + at * along) - kGroundRadiusM;
        depth += step * air.extinction(Air::density(height));
    }
    return glm::exp(-depth);
}

struct Scattered {
    DVec3 rayleigh{0.0}, mie{0.0};  ///< without phase functions
};

/// Sunlight that a ray from the ground gathers.
Scattered gather(const Air& air, const DVec2& along, const DVec2& to_sun) {
    constexpr double kEyeM = 2.0;
    const DVec2 eye(0.0, kGroundRadiusM + kEyeM);
    const double way = way_out(eye, along, kTopRadiusM);
    Scattered sum;
    DVec3 depth(0.0);
    for (int i = 0; i < kViewSteps; ++i) {
        const double t0 = double(i) / kViewSteps, t1 = double(i + 1) / kViewSteps;
        const double at = way * 0.5 * (t0 * t0 + t1 * t1), step = way * (t1 * t1 - t0 * t0);
        const DVec2 point = eye + at * along;
        const Air::Density density = Air::density(glm::length(point) - kGroundRadiusM);
        const DVec3 taken = step * air.extinction(density);
        // Light of the whole step dims on its way out of it.
        const DVec3 seen = glm::exp(-depth) * (DVec3(1.0) - glm::exp(-taken)) / glm::max(taken, DVec3(1e-12)) * step;
        const DVec3 lit = seen * transmittance(air, point, to_sun);
        sum.rayleigh += lit * air.rayleigh * density.rayleigh;
        sum.mie += lit * air.mie * kMieAlbedo * density.mie;
        depth += taken;
    }
    return sum;
}

double luminance(const DVec3& c) {
    return glm::dot(c, DVec3(0.2126, 0.7152, 0.0722));
}

/// Light of the table's sky from a direction of height y at an azimuth from the sun's.
DVec3 light_from(const scene::SkyTable& table, double y, double azimuth, const DVec2& to_sun) {
    const double level = std::sqrt(std::max(0.0, 1.0 - y * y));
    const double h = level * std::cos(azimuth), m = h * to_sun.x + y * to_sun.y;
    const double at = std::sqrt(y) * (scene::SkyTable::kRows - 1);
    const int i = std::min(int(at), scene::SkyTable::kRows - 2);
    const auto& a = table.rows[std::size_t(i)];
    const auto& b = table.rows[std::size_t(i + 1)];
    const auto mixed = [&](const Vec4& from, const Vec4& to) { return glm::mix(DVec3(from), DVec3(to), at - i); };
    const double g = kMieG;
    return (mixed(a.rayleigh, b.rayleigh) + h * mixed(a.rayleigh_sunward, b.rayleigh_sunward)) * (1.0 + m * m) +
           (mixed(a.mie, b.mie) + h * mixed(a.mie_sunward, b.mie_sunward)) * std::pow(1.0 + g * g - 2.0 * g * m, -1.5);
}

/// Mean over azimuths.
DVec3 mean_light_from(const scene::SkyTable& table, double y, const DVec2& to_sun) {
    constexpr int kAzimuths = 12;
    DVec3 sum(0.0);
    for (int k = 0; k < kAzimuths; ++k) sum += light_from(table, y, kPi * (k + 0.5) / kAzimuths, to_sun);
    return sum / double(kAzimuths);
}

/// What the sky sends to surfaces that face up and, in the mean of all azimuths, sideways; over pi, as light is that
/// lies on white.
struct SkyLight {
    DVec3 up{0.0}, side{0.0};
};
SkyLight sky_light(const scene::SkyTable& table, const DVec2& to_sun) {
    constexpr int kHeights = 16;
    SkyLight sum;
    for (int i = 0; i < kHeights; ++i) {
        const double y = (i + 0.5) / kHeights;
        const DVec3 light = mean_light_from(table, y, to_sun) / double(kHeights);
        sum.up += light * (2.0 * y);
        sum.side += light * (2.0 / kPi * std::sqrt(1.0 - y * y));
    }
    return sum;
}

}  // namespace

void light_atmosphere(scene::Environment& environment, scene::SkyTable& table) {
    // Haze has the optical depth that makes all of the air's turbidity times clean air's, in green.
    const double mie = (std::max(1.0f, environment.atmosphere.turbidity) - 1.0) * kGreenRayleigh *
                       double(kRayleighHeightM / kMieHeightM);
    const Air air{kRayleigh, mie};
    const double sun_y = std::clamp(double(environment.to_sun.y), -1.0, 1.0);
    const DVec2 to_sun(std::sqrt(1.0 - sun_y * sun_y), sun_y);

    constexpr int kRows = scene::SkyTable::kRows;
    const double rayleigh_phase = kMoreScattering * 3.0 / (16.0 * kPi);
    const double mie_phase = kMoreScattering * (1.0 - double(kMieG) * double(kMieG)) / (4.0 * kPi);
    for (int i = 0; i < kRows; ++i) {
        const double t = double(i) / (kRows - 1), y = t * t, level = std::sqrt(std::max(0.0, 1.0 - y * y));
        const Scattered toward = gather(air, {level, y}, to_sun), away = gather(air, {-level, y}, to_sun);
        const double slope = 0.5 / std::max(level, 1e-3);
        scene::SkyTable::Row& row = table.rows[std::size_t(i)];
        row.rayleigh = Vec4(0.5 * rayleigh_phase * (toward.rayleigh + away.rayleigh), 0.0);
        row.rayleigh_sunward = Vec4(slope * rayleigh_phase * (toward.rayleigh - away.rayleigh), 0.0);
        row.mie = Vec4(0.5 * mie_phase * (toward.mie + away.mie), 0.0);
        row.mie_sunward = Vec4(slope * mie_phase * (toward.mie - away.mie), 0.0);
    }

    // Of a sun that sets, the part of the disc above the horizon. The ray grazes the ground then: it starts at the
    // edge.
    const double risen = std::clamp(0.5 + 0.5 * std::asin(sun_y) / kSunRadius, 0.0, 1.0);
    const double ray_y = std::max(sun_y, 1e-6);
    const DVec3 sun = risen * transmittance(air, {0.0, kGroundRadiusM + 2.0}, {std::sqrt(1.0 - ray_y * ray_y), ray_y});
    SkyLight sky = sky_light(table, to_sun);
    const DVec3 night = kNightIlluminance / kPi * kNightTint;
    sky.up += night;
    sky.side += 0.5 * night;
    const DVec3 on_ground = sun * std::max(sun_y, 0.0) / kPi + sky.up;
    const double exposure =
        kExposure * std::pow(kPi * luminance(on_ground), kAdaptation) * double(environment.atmosphere.brightness);
    const auto exposed = [&](const DVec3& c) { return Vec3(exposure * c); };

    for (scene::SkyTable::Row& row : table.rows)
        for (Vec4* light : {&row.rayleigh, &row.rayleigh_sunward, &row.mie, &row.mie_sunward})
            *light *= float(exposure);
    table.night = exposed(kNightSky * night);
    table.rayleigh_per_m = Vec3(kRayleigh);
    table.mie_per_m = float(mie);
    table.light_up = exposed(sky.up);
    const auto shown = [&](const DVec3& light) { return Vec3(1.0) - glm::exp(-(Vec3(light) + table.night)); };
    environment.sun_radiance = exposed(sun / kPi);
    environment.sky_zenith = shown(light_from(table, 1.0, 0.5 * kPi, to_sun));
    environment.sky_horizon = shown(mean_light_from(table, 0.0, to_sun));
    environment.ground_bounce = exposed(kGroundAlbedo * on_ground);
    table.light_side = exposed(sky.side) + 0.5f * environment.ground_bounce;
    environment.sky = &table;
}

}  // namespace ff::shading
