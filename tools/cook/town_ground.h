#pragma once
// Ground for a town: the landscape, softened where the town stands.

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "tools/cook/buildings_footprint.h"
#include "tools/cook/terrain.h"

namespace ff::cook {

/// Runs smoothly between the landscape's heights on a lattice that is anchored to the world, so that a town that grows
/// keeps the ground that it has; from the flat radius outwards it turns into the landscape itself.
class TownGround {
  public:
    static constexpr double kBlend = 400.0;  ///< m from the soft ground to the landscape

    /// @param landscape  height at (x, z); kept
    TownGround(double center_x, double center_z, double flat_radius_m, std::function<double(double, double)> landscape);

    [[nodiscard]] double height_at(double x, double z) const;
    /// The square beyond which the landscape is untouched.
    [[nodiscard]] RectXZ extent() const;

  private:
    double center_x_, center_z_, radius_;
    std::function<double(double, double)> landscape_;
    int lattice_x_ = 0, lattice_z_ = 0, columns_ = 0;
    std::vector<double> lattice_;
};

/// Gives the field the town's ground, and sinks it by a metre below the blocks: samples that lie in the blocks with all
/// their neighbours. So the streets never fight with the ground below them, and nothing shows at their border.
/// @param blocks  outlines (x, z) that tile the town
void shape_ground(HeightField& field, const TownGround& ground, std::span<const std::array<DVec2, 4>> blocks);

/// Rectangles of the field where every sample must stay (Terrain's `exact`): the town's border runs through them.
[[nodiscard]] std::vector<RectXZ> bounds_of(std::span<const std::array<DVec2, 4>> blocks, double margin_m);

}  // namespace ff::cook
