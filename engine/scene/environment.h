#pragma once

#include <cstdint>
#include <span>

#include "engine/math/types.h"

namespace ff::scene {

/// Air that scatters light: sky, sunlight and aerial perspective follow from where the sun stands.
struct Atmosphere {
    float turbidity = 0.0f;   ///< haze: optical depth of the air over that of clean air. [1, 10]; 0: no such model
    float brightness = 1.0f;  ///< of the picture; 1: as the default daylight

    friend bool operator==(const Atmosphere&, const Atmosphere&) = default;
};

/// What falls, and what blows.
struct Weather {
    float rain = 0.0f, snow = 0.0f;  ///< strength, [0, 1]
    Vec2 wind_m_s{0.0f};             ///< where it blows to: x, z

    friend bool operator==(const Weather&, const Weather&) = default;
};

struct SkyTable;  // sky_table.h

/// Sun, sky and air, as shading reads them.
struct Environment {
    Vec3 to_sun{0.45f, 0.62f, 0.64f};        ///< unit, world
    Vec3 sun_radiance{1.14f, 1.05f, 0.91f};  ///< linear RGB; times cos and albedo gives the lit colour
    Vec3 sky_zenith{0.20f, 0.42f, 0.80f};    ///< linear RGB
    Vec3 sky_horizon{0.70f, 0.80f, 0.90f};
    Vec3 ground_bounce{0.18f, 0.16f, 0.13f};  ///< light from below
    bool sun_shadows = false;                 ///< what stands between a surface and the sun keeps its light away
    float fog_density_per_m = 0.0f;           ///< 0: none; colour is the horizon's
    Atmosphere atmosphere;
    Weather weather;
    const SkyTable* sky = nullptr;  ///< borrowed; the gradient from zenith to horizon where there is none
    /// Equirectangular sky instead of the gradient, where given: RGBA16F, width x height, row 0 at the zenith, column 0
    /// looking north (-z), growing to the east.
    std::uint32_t panorama_width = 0, panorama_height = 0;
    std::span<const std::uint16_t> panorama;
};

}  // namespace ff::scene
