#pragma once
// Masked and blended triangles under Embree: a hit that its material lets through is no hit.

#include <embree3/rtcore.h>

#include "engine/math/leaf_sway.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield::embree {

/// What travels with every query: the filter has to know how wide a ray is.
struct CastContext {
    RTCIntersectContext context;     ///< first, so that Embree's pointer is ours
    float pixel_angle = 0.0f;        ///< width of a ray per length; 0 for bare rays
    float blend_within_m = 0.0f;     ///< as in PinholeView; 0 for bare rays
    const LeafSway* sway = nullptr;  ///< likewise; nullptr for bare rays, which all start at the eye otherwise
};

/// RTCFilterFunctionN: switches off the lanes whose hit lies on a see-through texel or a
/// transparent layer (alpha_test.h). The geometry's
/// user data is the StaticScene; its attachments are numbered as the scene's instances are.
void filter_see_through(const RTCFilterFunctionNArguments* arguments);

}  // namespace ff::farfield::embree
