#pragma once
// Clear and hazy air around the planet: what it scatters and absorbs, and what of a ray comes through.

#include <algorithm>
#include <cmath>

#include "engine/math/types.h"
#include "engine/shading/atmosphere.h"

namespace ff::shading {

/// Points and directions lie in the plane of zenith and sun: x towards the sun, y up, from the planet's middle, metres.
using PlaneVec = glm::dvec2;

inline constexpr double kGroundRadiusM = 6360e3, kTopRadiusM = 6420e3;
/// Per metre at height 0, at 615, 535 and 445 nm, the middles of sRGB's primaries: the sources' values at 550 nm,
/// Rayleigh by the inverse fourth power, ozone in proportion to the Chappuis band's cross sections. (At the sources'
/// 680, 550 and 440 nm ozone takes most of green, and dusk is purple.)
inline const DVec3 kRayleigh(8.67e-6, 15.14e-6, 31.6e-6);
inline const DVec3 kOzone(2.60e-6, 1.50e-6, 0.090e-6);
inline constexpr double kOzoneMiddleM = 25e3, kOzoneHalfM = 15e3;
/// Of haze, the share of what it takes from a ray that it scatters.
inline constexpr double kMieAlbedo = 0.9;
/// Ground's mean albedo, which light from below has.
inline const DVec3 kGroundAlbedo(0.21, 0.19, 0.15);

/// Haze takes more of short waves: by the power -1.3 of the wavelength (Angstrom, 1929), over what it takes at 550 nm.
inline const DVec3 kMieColor(0.865, 1.037, 1.317);

struct Air {
    DVec3 mie;  ///< haze's extinction per metre at height 0

    struct Density {
        double rayleigh, mie, ozone;  ///< of what is densest
    };
    static Density density(double height_m) {
        return {std::exp(-height_m / double(kRayleighHeightM)), std::exp(-height_m / double(kMieHeightM)),
                std::max(0.0, 1.0 - std::abs(height_m - kOzoneMiddleM) / kOzoneHalfM)};
    }
    [[nodiscard]] DVec3 extinction(const Density& d) const {
        return kRayleigh * d.rayleigh + mie * d.mie + kOzone * d.ozone;
    }
    [[nodiscard]] DVec3 scattering(const Density& d) const {
        return kRayleigh * d.rayleigh + mie * (kMieAlbedo * d.mie);
    }
};

/// Way to a sphere around the planet's middle from a point inside it, metres.
[[nodiscard]] double way_out(const PlaneVec& from, const PlaneVec& along, double radius_m);

[[nodiscard]] bool hits_ground(const PlaneVec& from, const PlaneVec& along);

/// Share of a ray's light that leaves the air; none of one that ends on the ground.
[[nodiscard]] DVec3 transmittance(const Air& air, const PlaneVec& from, const PlaneVec& along);

/// Calls visit(point, density, seen) for the steps of a ray through air, from `from` on: `seen` is the length of the
/// step in metres, less what is lost on its light's way back to `from`. Steps grow: the air is densest, or nearest,
/// where the ray begins.
/// @return share of light that comes through all of it
template <int kSteps, class Visit>
DVec3 march(const Air& air, const PlaneVec& from, const PlaneVec& along, double way_m, const Visit& visit) {
    DVec3 through(1.0);
    for (int i = 0; i < kSteps; ++i) {
        const double t0 = double(i) / kSteps, t1 = double(i + 1) / kSteps;
        const double at = way_m * 0.5 * (t0 * t0 + t1 * t1), step = way_m * (t1 * t1 - t0 * t0);
        const PlaneVec point = from + at * along;
        const Air::Density density = Air::density(glm::length(point) - kGroundRadiusM);
        const DVec3 taken = step * air.extinction(density), kept = glm::exp(-taken);
        // Light of the whole step dims on its way out of it.
        visit(point, density, through * (DVec3(1.0) - kept) / glm::max(taken, DVec3(1e-12)) * step);
        through *= kept;
    }
    return through;
}

}  // namespace ff::shading
