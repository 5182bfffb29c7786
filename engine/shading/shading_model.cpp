#include "engine/shading/shading_model.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace ff::shading {

DVec3 encode_color(const DVec3& linear, bool by_film) {
    const double luminance = glm::dot(linear, DVec3(kLuminance[0], kLuminance[1], kLuminance[2]));
    DVec3 encoded(0.0);
    for (int k = 0; k < 3; ++k) {
        const double shown = by_film ? luminance + double(kFilmColor) * (linear[k] - luminance) : linear[k];
        const double x = shown > 0.0 ? std::min(shown, 1.0) : 0.0;  // NaN is black
        if (!by_film) {
            encoded[k] = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
            continue;
        }
        const double s = std::sqrt(x);
        encoded[k] = kFilm[0] + s * (kFilm[1] + s * (kFilm[2] + s * (kFilm[3] + s * double(kFilm[4]))));
    }
    return encoded;
}

ShadingUniforms make_uniforms(const scene::Environment& environment, const PinholeView& view) {
    const Vec3 zenith = environment.sky_zenith, horizon = environment.sky_horizon;
    // Light on surfaces that face up, sideways and down; a parabola in the normal's height goes through all three.
    const scene::SkyTable* const table = environment.sky;
    const Vec3 up = table != nullptr ? table->light_up : kSkyLight * glm::mix(zenith, horizon, 0.4f);
    const Vec3 down = environment.ground_bounce;
    const Vec3 side =
        table != nullptr ? table->light_side : 0.5f * (kSkyLight * glm::mix(zenith, horizon, 0.6f) + down);
    const bool has_panorama = environment.panorama_width > 0 && environment.panorama_height > 0;

    const float pixel_angle = view.pixel_angle();
    ShadingUniforms uniforms{};
    uniforms.to_sun = Vec4(glm::normalize(environment.to_sun), environment.fog_density_per_m);
    uniforms.sun_radiance = Vec4(environment.sun_radiance, pixel_angle * pixel_angle);
    uniforms.ambient_side = Vec4(side, 0);
    uniforms.ambient_slope = Vec4(0.5f * (up - down), 0);
    uniforms.ambient_curve = Vec4(0.5f * (up + down) - side, 0);
    uniforms.horizon = Vec4(horizon, 0);
    uniforms.zenith = Vec4(zenith, 0);
    uniforms.haze = Vec4(glm::mix(horizon, environment.ground_bounce, 0.55f), 0);
    uniforms.panorama_size =
        has_panorama ? Vec4(environment.panorama_width, environment.panorama_height, 0, 0) : Vec4(0.0f);
    if (environment.sky == nullptr || has_panorama) return uniforms;

    const scene::SkyTable& sky = *environment.sky;
    uniforms.panorama_size.z = uniforms.panorama_size.w = 1.0f;
    const Vec3 level(environment.to_sun.x, 0.0f, environment.to_sun.z);
    uniforms.sunward = Vec4(level / std::max(glm::length(level), 1e-6f), 0);
    uniforms.night = Vec4(sky.night, 0);
    const auto thinned = [&](float height_m) {
        return float(std::exp(-std::max(view.position.y, 0.0) / double(height_m)));
    };
    uniforms.air = Vec4(sky.rayleigh_per_m * thinned(kRayleighHeightM), 0);
    uniforms.haze_air = Vec4(sky.mie_per_m * thinned(kMieHeightM) + environment.fog_density_per_m, 0);
    std::copy(sky.rows.begin(), sky.rows.end(), uniforms.sky_rows);
    return uniforms;
}

}  // namespace ff::shading
