#include "engine/effects/daylight.h"

#include <algorithm>
#include <cmath>

#include "engine/shading/atmosphere.h"

namespace ff::effects {

Vec3 rounded_sun(const Vec3& to_sun, float step_rad) {
    if (!(step_rad > 0.0f)) return to_sun;
    const double step = step_rad;
    const auto rounded = [&](double angle) { return std::round(angle / step) * step; };
    const double elevation = rounded(std::asin(std::clamp(double(to_sun.y), -1.0, 1.0)));
    const double azimuth = rounded(std::atan2(double(to_sun.x), -double(to_sun.z)));
    return Vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation), -std::cos(elevation) * std::cos(azimuth));
}

struct Daylight::Lit {
    Vec3 to_sun{0.0f};
    scene::Atmosphere atmosphere;
    scene::Weather weather;
    scene::SkyTable table;
    scene::Environment light;  ///< colours alone
};

Daylight::Daylight() = default;
Daylight::~Daylight() = default;

void Daylight::light(scene::Environment& environment) {
    environment.sky = nullptr;
    if (!(environment.atmosphere.turbidity > 0.0f)) {
        if (environment.to_sun.y < 0.0f) environment.sun_radiance = Vec3(0.0f);
        return;
    }
    if (!lit_) lit_ = std::make_unique<Lit>();
    if (lit_->to_sun != environment.to_sun || lit_->atmosphere != environment.atmosphere ||
        lit_->weather != environment.weather) {
        lit_->to_sun = environment.to_sun;
        lit_->atmosphere = environment.atmosphere;
        lit_->weather = environment.weather;
        lit_->light = environment;
        shading::light_atmosphere(lit_->light, lit_->table);
        ++made_;
    }
    environment.sun_radiance = lit_->light.sun_radiance;
    environment.sky_zenith = lit_->light.sky_zenith;
    environment.sky_horizon = lit_->light.sky_horizon;
    environment.ground_bounce = lit_->light.ground_bounce;
    environment.sky = &lit_->table;
}

}  // namespace ff::effects
