#pragma once
// Masked and blended triangles under Embree: a hit that its material lets through is no hit.

#include <embree3/rtcore.h>

#include <cstdint>

#include "engine/scene/static_scene.h"

namespace ff::farfield::embree {

/// What the filter reads of the scene; a copy of the spans, so that it outlives the caller's view.
struct AlphaScene {
    scene::StaticScene scene;
};

/// User data of an Embree geometry that has see-through triangles.
struct AlphaMesh {
    const AlphaScene* owner = nullptr;
    std::uint32_t mesh = 0;
};

/// RTCFilterFunctionN: switches off the lanes whose hit lies on a see-through texel.
void filter_see_through(const RTCFilterFunctionNArguments* arguments);

}  // namespace ff::farfield::embree
