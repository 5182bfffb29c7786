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

namespace {

/// Bounds of the light of the atmosphere that surfaces fade into: that of the sky's lowest row.
void bound_air(const ShadingUniforms& uniforms, NearAir& near) {
    const scene::SkyTable::Row& row = uniforms.sky_rows[0];
    const float least_phase = 1.0f / ((1.0f + kMieG) * (1.0f + kMieG) * (1.0f + kMieG));
    near.brightest = near.darkest = 1.0f;  // as it is shown
    for (int k = 0; k < 3; ++k) {
        const float rayleigh = row.rayleigh[k], rayleigh_grows = std::abs(row.rayleigh_sunward[k]);
        const float haze = row.mie[k], haze_grows = std::abs(row.mie_sunward[k]);
        const float again = row.again()[k], again_grows = again * std::abs(row.again_sunward());
        const float night = uniforms.night[k];
        near.bright = std::max(near.bright, 2.0f * (rayleigh + rayleigh_grows) + again + again_grows + night);
        near.ahead = std::max(near.ahead, haze + haze_grows);
        const float least = std::max(0.0f, rayleigh - rayleigh_grows) +
                            std::max(0.0f, haze - haze_grows) * least_phase + std::max(0.0f, again - again_grows) +
                            night;
        near.darkest = std::min(near.darkest, 1.0f - std::exp(-least * (1.0f + 0.5f * least)));
    }
}

float largest(const Vec4& color) {
    return std::max({color.x, color.y, color.z});
}

}  // namespace

NearAir make_near_air(const ShadingUniforms& uniforms, float air_error) {
    const bool has_atmosphere = uniforms.panorama_size.z > 0.0f, by_film = uniforms.panorama_size.w > 0.0f;
    const float per_m = has_atmosphere ? largest(uniforms.air + uniforms.haze_air) : uniforms.to_sun.w;
    if (!(per_m > 0.0f) || !(air_error > 0.0f)) return {};
    NearAir near{.root = air_error / kEncodeSlope, .spread = by_film ? kFilmColor - 1.0f : 0.0f};
    // Film pulls channels apart: each changes by what it and the luminance do.
    near.clear_m = near.root / (per_m * (1.0f + 2.0f * near.spread));
    const auto reach = [&] { return near.clear_m * std::max(1.0f, near.root) / kLeastAirContrast; };
    near.reach_m = reach();
    if (!has_atmosphere) {
        near.bright = near.brightest = largest(uniforms.horizon);
        near.darkest = std::min({uniforms.horizon.x, uniforms.horizon.y, uniforms.horizon.z});
        return near;
    }
    bound_air(uniforms, near);  // shown, it is no brighter than it is
    // Who looks down looks into denser air: by this, at most, in the mean of the way.
    const float heights = std::min(near.reach_m / kMieHeightM, 1.0f);
    near.clear_m *= heights / std::expm1(heights);
    near.reach_m = std::min(reach(), kMieHeightM);
    return near;
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
