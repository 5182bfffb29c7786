#pragma once
// Where a scene's lamps are, and which of them light a view.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/math/camera.h"
#include "engine/scene/lamp.h"
#include "engine/shading/lamp_light.h"

namespace ff::effects {

/// How bright a lamp is while the sun stands at an elevation: from nothing to all within two degrees. [0, 1]
[[nodiscard]] double lamp_brightness(const scene::Lamp& lamp, double sun_elevation_deg);

/// A scene's lamps, sorted into squares of the ground.
class LampGrid {
  public:
    /// Borrows the lamps. Takes no memory where there are none.
    explicit LampGrid(std::span<const scene::Lamp> lamps);

    [[nodiscard]] bool is_empty() const { return lamps_.empty(); }
    /// Sun's elevation below which the first of all lamps is lit, degrees.
    [[nodiscard]] double first_on_below_deg() const { return first_on_below_deg_; }
    /// Whether the light of some lamp reaches within that distance of the eye.
    [[nodiscard]] bool has_lamp_within(const WorldPos& eye, double within_m) const;
    /// Lamps whose light may be seen in a view, the nearest first; at most kMaxLamps, the nearest.
    /// @param within_m  of the eye; lamps fade out over the last fifth, so that none pops up
    /// @param out       replaced; no allocation once it has held as many
    void find_lit(const PinholeView& view, double sun_elevation_deg, double within_m,
                  std::vector<shading::LampLight>& out) const;

    static constexpr std::size_t kMaxLamps = 1024;

  private:
    static constexpr double kSquareM = 64.0;
    template <class Body>
    void each_within(const WorldPos& eye, double within_m, Body&& body) const;

    std::span<const scene::Lamp> lamps_;
    double low_x_ = 0.0, low_z_ = 0.0, largest_radius_m_ = 0.0, first_on_below_deg_ = -90.0;
    int columns_ = 0, rows_ = 0;
    std::vector<std::uint32_t> first_;  ///< by square, into order_; one more than squares
    std::vector<std::uint32_t> order_;  ///< lamps by square
};

}  // namespace ff::effects
