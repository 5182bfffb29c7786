#pragma once
// Inner interface between HorizonMap and the walk of the scene's own boxes around the eye; not for users.

#include <cstdint>

#include "engine/farfield/horizon_trace.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

struct HorizonNearInput {
    const scene::StaticScene* scene = nullptr;
    WorldPos eye{0.0};
    float roam_m = 0;       ///< the eye may be anywhere within this distance horizontally,
    float climb_m = 0;      ///< and this far above or below
    float reach_m = 0;      ///< boxes whose nearest point is horizontally farther are left out
    HorizonWedges wedges;   ///< in metres
    const float* border_x;  ///< [columns + 1], readable 16 beyond: unit directions between the columns
    const float* border_z;
};

/// Raises `tangents` ([columns + 16], the 16 beyond +inf) by everything static within reach.
/// @return boxes and triangles whose bound was computed.
std::uint32_t trace_horizon_near(const HorizonNearInput& input, float* tangents);

}  // namespace ff::farfield
