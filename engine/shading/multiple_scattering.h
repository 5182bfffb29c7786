#pragma once
// Light that the air has scattered more than once, by successive orders of scattering.

#include <array>

#include "engine/shading/air.h"

namespace ff::shading {

/// Mean radiance over all directions of light that has been scattered or reflected by the ground at least once, by the
/// height and by the sun's elevation there; of a sun that gives 1 above the air. What scatters at a point sends
/// Air::scattering times this to everywhere.
///
/// Sources: successive orders of scattering (van de Hulst, "Multiple Light Scattering", 1980); as in Hillaire, "A
/// Scalable and Production Ready Sky and Atmosphere Rendering Technique", EGSR 2020, every order but the first is taken
/// to leave evenly in all directions, and the sun to stand at one elevation as far as light is scattered. Ours differs:
/// orders are summed over a column of heights, instead of as a series at each height alone.
class MultipleScattering {
  public:
    /// For points where the sun stands within kReachRad of the given elevation. About 0.2 ms.
    MultipleScattering(const Air& air, double sun_elevation_rad);

    /// @param height_m  above the ground, [0, 60e3]; clamped
    /// @param sun_elevation_rad  there; clamped to kReachRad around the constructor's
    [[nodiscard]] DVec3 at(double height_m, double sun_elevation_rad) const;

    /// A ray that leaves the ground level ends 7.8 degrees round the planet.
    static constexpr double kReachRad = 8.0 * kPi / 180.0;

  private:
    static constexpr int kHeights = 8, kSuns = 7;
    double first_sun_rad_;
    std::array<std::array<DVec3, kHeights>, kSuns> mean_;
};

}  // namespace ff::shading
