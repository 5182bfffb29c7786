#pragma once

#include <array>

#include "engine/math/types.h"

namespace ff::scene {

/// The sky at one position of the sun, as shading/atmosphere.h makes it: by the height y of a unit direction, rows at
/// y = (i / (kRows - 1))^2. With h the direction's part towards the sun's azimuth and m its cosine to the sun, light is
/// (rayleigh + h rayleigh_sunward) (1 + m^2) + (mie + h mie_sunward) (1 + g^2 - 2 g m)^-1.5 + again (1 + h
/// again_sunward) + night; it shows as 1 - exp(-light - light^2 / 2).
struct SkyTable {
    static constexpr int kRows = 32;
    struct alignas(16) Row {
        Vec4 rayleigh{0.0f}, rayleigh_sunward{0.0f}, mie{0.0f}, mie_sunward{0.0f};  ///< RGB, linear
        /// Light scattered more than once, in the vectors' fourth places.
        [[nodiscard]] Vec3 again() const { return {rayleigh.w, rayleigh_sunward.w, mie.w}; }
        [[nodiscard]] float again_sunward() const { return mie_sunward.w; }  ///< its share of growth
    };
    std::array<Row, kRows> rows;
    Vec3 night{0.0f};                       ///< light of the sky at night, from everywhere
    Vec3 light_up{0.0f}, light_side{0.0f};  ///< on white surfaces that face up and sideways, without the sun
    Vec3 rayleigh_per_m{0.0f};              ///< extinction at height 0
    Vec3 mie_per_m{0.0f};                   ///< likewise
};

}  // namespace ff::scene
