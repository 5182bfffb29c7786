#pragma once
// What a pixel sees, in double: who is right where two casters differ.

#include <cstdint>

#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::bench {

/// The nearest hit of a pixel's ray, or sky.
struct ExactHit {
    std::uint32_t instance = farfield::kSkyInstance, triangle = 0;
    double depth = 0.0;  ///< along the view axis, metres; of a hit
};

/// Walks the scene's own hierarchies with one ray whose every number is a double, see-through surfaces by the rule of
/// alpha_test.h. For views without transparent layers. Microseconds a ray.
[[nodiscard]] ExactHit find_exact_hit(const scene::StaticScene& scene, const PinholeView& view, int x, int y);

/// Whether an answer names another primitive than the exact hit and is no tie in depth with it
/// (farfield/visibility_difference.h).
[[nodiscard]] bool is_wrong(const farfield::VisibilityBuffer& answers, std::size_t at, const ExactHit& exact);

}  // namespace ff::bench
