#include "engine/shading/atmosphere.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "engine/shading/air.h"
#include "engine/shading/multiple_scattering.h"

namespace ff::shading {
namespace {

/// Of the eye above the ground.
constexpr double kEyeM = 2.0;
constexpr double kGreenRayleigh = 13.558e-6;  ///< at 550 nm, of which turbidity speaks
/// Sun's angular radius, radians.
constexpr double kSunRadius = 0.00465;
/// Full moon and stars on level ground, over the sun above the air.
constexpr double kNightIlluminance = 1.5e-6;
const DVec3 kNightTint(0.62, 0.82, 1.25);
/// Share of it that comes from the whole sky; the rest is the moon's, which is not drawn.
constexpr double kNightSky = 0.25;
/// The eye's adaptation: what remains of a difference in illuminance is its power 1 + this.
constexpr double kAdaptation = -0.8;
/// So that level ground in the sun at noon is as bright as by the default daylight.
constexpr double kExposure = 3.8;

/// Sunlight that a ray from the ground gathers.
struct Scattered {
    DVec3 rayleigh{0.0}, mie{0.0};  ///< scattered once, without phase functions
    DVec3 again{0.0};               ///< scattered more often
};
Scattered gather(const Air& air, const MultipleScattering& multiple, const PlaneVec& along, const PlaneVec& to_sun) {
    constexpr int kSteps = 32;
    const PlaneVec eye(0.0, kGroundRadiusM + kEyeM);
    Scattered sum;
    march<kSteps>(air, eye, along, way_out(eye, along, kTopRadiusM),
                  [&](const PlaneVec& point, const Air::Density& density, const DVec3& seen) {
                      const DVec3 lit = seen * transmittance(air, point, to_sun);
                      sum.rayleigh += lit * kRayleigh * density.rayleigh;
                      sum.mie += lit * air.mie * (kMieAlbedo * density.mie);
                      const double radius = glm::length(point);
                      const double sun_there = std::asin(std::clamp(glm::dot(point, to_sun) / radius, -1.0, 1.0));
                      sum.again += seen * air.scattering(density) * multiple.at(radius - kGroundRadiusM, sun_there);
                  });
    return sum;
}

double luminance(const DVec3& c) {
    return glm::dot(c, DVec3(0.2126, 0.7152, 0.0722));
}

/// Light of the table's sky from a direction of height y at an azimuth from the sun's.
DVec3 light_from(const scene::SkyTable& table, double y, double azimuth, const PlaneVec& to_sun) {
    const double level = std::sqrt(std::max(0.0, 1.0 - y * y));
    const double h = level * std::cos(azimuth), m = h * to_sun.x + y * to_sun.y;
    const double at = std::sqrt(y) * (scene::SkyTable::kRows - 1);
    const int i = std::min(int(at), scene::SkyTable::kRows - 2);
    const auto& a = table.rows[std::size_t(i)];
    const auto& b = table.rows[std::size_t(i + 1)];
    const auto mixed = [&](const Vec4& from, const Vec4& to) { return glm::mix(DVec3(from), DVec3(to), at - i); };
    const double g = kMieG;
    return (mixed(a.rayleigh, b.rayleigh) + h * mixed(a.rayleigh_sunward, b.rayleigh_sunward)) * (1.0 + m * m) +
           (mixed(a.mie, b.mie) + h * mixed(a.mie_sunward, b.mie_sunward)) * std::pow(1.0 + g * g - 2.0 * g * m, -1.5) +
           glm::mix(DVec3(a.again()), DVec3(b.again()), at - i) *
               (1.0 + h * glm::mix(double(a.again_sunward()), double(b.again_sunward()), at - i));
}

/// Mean over azimuths.
DVec3 mean_light_from(const scene::SkyTable& table, double y, const PlaneVec& to_sun) {
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
SkyLight sky_light(const scene::SkyTable& table, const PlaneVec& to_sun) {
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

/// Share of the sky that clouds cover; already weak rain and snow fall from a closed sky.
double cloud_cover(const scene::Weather& weather) {
    return std::clamp(3.0 * double(std::max(weather.rain, weather.snow)), 0.0, 1.0);
}

/// Draws clouds over a clear sky: they spread a part of what would lie on level ground, as the CIE's standard overcast
/// sky (Moon and Spencer 1942), three times as bright above as at the horizon.
/// @param on_ground  light on white level ground below the clear sky, sun and sky
void add_clouds(scene::SkyTable& table, double cover, const DVec3& on_ground) {
    constexpr double kTransmitted = 0.06;
    const DVec3 tint(0.95, 1.0, 1.09);
    // Clouds are gray, at 7,000 K: what is blue or red of the light on them is mixed by many ways through them.
    const DVec3 zenith = 9.0 / 7.0 * kTransmitted * 0.5 * tint * (on_ground + DVec3(luminance(on_ground)));
    for (int i = 0; i < scene::SkyTable::kRows; ++i) {
        const double t = double(i) / (scene::SkyTable::kRows - 1);
        scene::SkyTable::Row& row = table.rows[std::size_t(i)];
        const DVec3 cloud = (1.0 + 2.0 * t * t) / 3.0 * zenith;
        const DVec3 again = glm::mix(DVec3(row.again()), cloud, cover);
        const auto thinned = [&](const Vec4& light, double fourth) {
            return Vec4((1.0 - cover) * DVec3(light), fourth);
        };
        row.rayleigh = thinned(row.rayleigh, again.r);
        row.rayleigh_sunward = thinned(row.rayleigh_sunward, again.g);
        row.mie = thinned(row.mie, again.b);
        row.mie_sunward = thinned(row.mie_sunward, (1.0 - cover) * double(row.again_sunward()));
    }
}

}  // namespace

void light_atmosphere(scene::Environment& environment, scene::SkyTable& table) {
    // Haze has the optical depth that makes all of the air's turbidity times clean air's, in green.
    const double mie_at_550 = (std::max(1.0f, environment.atmosphere.turbidity) - 1.0) * kGreenRayleigh *
                              double(kRayleighHeightM / kMieHeightM);
    const Air air{mie_at_550 * kMieColor};
    const double sun_y = std::clamp(double(environment.to_sun.y), -1.0, 1.0);
    const PlaneVec to_sun(std::sqrt(1.0 - sun_y * sun_y), sun_y);

    constexpr int kRows = scene::SkyTable::kRows;
    const MultipleScattering multiple(air, std::asin(sun_y));
    const double rayleigh_phase = 3.0 / (16.0 * kPi);
    const double mie_phase = (1.0 - double(kMieG) * double(kMieG)) / (4.0 * kPi);
    for (int i = 0; i < kRows; ++i) {
        const double t = double(i) / (kRows - 1), y = t * t, level = std::sqrt(std::max(0.0, 1.0 - y * y));
        const Scattered toward = gather(air, multiple, {level, y}, to_sun),
                        away = gather(air, multiple, {-level, y}, to_sun);
        const double slope = 0.5 / std::max(level, 1e-3);
        scene::SkyTable::Row& row = table.rows[std::size_t(i)];
        const DVec3 again = 0.5 * (toward.again + away.again);
        const double again_sunward = slope * luminance(toward.again - away.again) / std::max(luminance(again), 1e-30);
        row.rayleigh = Vec4(0.5 * rayleigh_phase * (toward.rayleigh + away.rayleigh), again.r);
        row.rayleigh_sunward = Vec4(slope * rayleigh_phase * (toward.rayleigh - away.rayleigh), again.g);
        row.mie = Vec4(0.5 * mie_phase * (toward.mie + away.mie), again.b);
        row.mie_sunward = Vec4(slope * mie_phase * (toward.mie - away.mie), again_sunward);
    }

    // Of a sun that sets, the part of the disc above the horizon. The ray grazes the ground then: it starts at the
    // edge.
    const double risen = std::clamp(0.5 + 0.5 * std::asin(sun_y) / kSunRadius, 0.0, 1.0);
    const double ray_y = std::max(sun_y, 1e-6);
    DVec3 sun = risen * transmittance(air, {0.0, kGroundRadiusM + kEyeM}, {std::sqrt(1.0 - ray_y * ray_y), ray_y});
    SkyLight sky = sky_light(table, to_sun);
    if (const double cover = cloud_cover(environment.weather); cover > 0.0) {
        add_clouds(table, cover, sun * std::max(sun_y, 0.0) / kPi + sky.up);
        sky = sky_light(table, to_sun);
        sun *= 1.0 - cover;
    }
    const DVec3 night = kNightIlluminance / kPi * kNightTint;
    sky.up += night;
    sky.side += 0.5 * night;
    const DVec3 on_ground = sun * std::max(sun_y, 0.0) / kPi + sky.up;
    const double exposure =
        kExposure * std::pow(kPi * luminance(on_ground), kAdaptation) * double(environment.atmosphere.brightness);
    const auto exposed = [&](const DVec3& c) { return Vec3(exposure * c); };

    for (scene::SkyTable::Row& row : table.rows) {
        const float again_sunward = row.again_sunward();  // a share: stays
        for (Vec4* light : {&row.rayleigh, &row.rayleigh_sunward, &row.mie, &row.mie_sunward})
            *light *= float(exposure);
        row.mie_sunward.w = again_sunward;
    }
    table.night = exposed(kNightSky * night);
    table.rayleigh_per_m = Vec3(kRayleigh);
    table.mie_per_m = Vec3(air.mie);
    table.light_up = exposed(sky.up);
    const auto shown = [&](const DVec3& light) {
        const Vec3 all = Vec3(light) + table.night;
        return Vec3(1.0) - glm::exp(-all * (1.0f + 0.5f * all));
    };
    environment.sun_radiance = exposed(sun / kPi);
    environment.sky_zenith = shown(light_from(table, 1.0, 0.5 * kPi, to_sun));
    environment.sky_horizon = shown(mean_light_from(table, 0.0, to_sun));
    environment.ground_bounce = exposed(kGroundAlbedo * on_ground);
    table.light_side = exposed(sky.side) + 0.5f * environment.ground_bounce;
    environment.sky = &table;
}

}  // namespace ff::shading
