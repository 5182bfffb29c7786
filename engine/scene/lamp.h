#pragma once

#include "engine/math/types.h"

namespace ff::scene {

/// A point that lights what is around it once the sun is low.
struct Lamp {
    WorldPos position{0.0};
    Vec3 color{1.0f, 0.82f, 0.55f};  ///< linear RGB, at most 1
    float lumens = 3000.0f;          ///< in all directions together
    float radius_m = 18.0f;          ///< beyond it gives no light. (0, 1000]
    float on_below_sun_deg = 2.0f;   ///< elevation of the sun below which it is lit. [-90, 90]

    friend bool operator==(const Lamp&, const Lamp&) = default;
};

}  // namespace ff::scene
