#include "engine/shading/shading_model.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace ff::shading {

ShadingUniforms make_uniforms(const scene::Environment& environment, float pixel_angle) {
    const Vec3 zenith = environment.sky_zenith, horizon = environment.sky_horizon;
    // Light on surfaces that face up, sideways and down; a parabola in the normal's height goes through all three.
    const Vec3 up = kSkyLight * glm::mix(zenith, horizon, 0.4f);
    const Vec3 down = environment.ground_bounce;
    const Vec3 side = 0.5f * (kSkyLight * glm::mix(zenith, horizon, 0.6f) + down);
    const bool has_panorama = environment.panorama_width > 0 && environment.panorama_height > 0;

    ShadingUniforms uniforms;
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
    return uniforms;
}

}  // namespace ff::shading
