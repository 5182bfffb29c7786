#pragma once
// Light of a day that passes: the sun may stand elsewhere than where the scene put it, and light and sky follow.

#include <memory>
#include <optional>

#include "engine/scene/environment.h"

namespace ff::effects {

/// A sun's direction rounded to multiples of an angle in azimuth and elevation, so that what is lit by it stays good
/// until it has moved so far. It depends on nothing but the direction: a frame alone is as one among many.
/// @param to_sun   unit
/// @param step_rad  [0, 0.1]; 0: as it is
[[nodiscard]] Vec3 rounded_sun(const Vec3& to_sun, float step_rad);

/// The sky's table of the last sun that was asked for, which takes half a millisecond to make.
class Daylight {
  public:
    Daylight();
    ~Daylight();
    /// Gives an environment the light of its sun. One with an atmosphere gets sunlight, sky and light from below from
    /// where the sun stands, and points into this object; any other keeps its colours, but for a sun that is below the
    /// horizon.
    void light(scene::Environment& environment);
    /// Tables made so far.
    [[nodiscard]] std::uint64_t made() const { return made_; }

  private:
    struct Lit;
    std::unique_ptr<Lit> lit_;  ///< made when first asked for
    std::uint64_t made_ = 0;
};

}  // namespace ff::effects
