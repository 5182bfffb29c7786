#pragma once
// The knobs of the Embree caster; make_embree_caster(scene) of ray_caster.h uses the defaults, which were measured
// (tests/bench/bench_casters).

#include <memory>

#include "engine/farfield/ray_caster.h"

namespace ff::farfield {

struct EmbreeOptions {
    /// Rays a packet: 8 or 16; 0: what the machine is fastest with.
    int packet_width = 0;
    /// Watertight intersection tests: no ray slips through an edge that two triangles share.
    bool robust = true;
    /// Smaller BVH, somewhat slower rays.
    bool compact = false;
};

/// The scene's arrays must outlive the caster: Embree reads indices and vertices in place where it can.
std::unique_ptr<RayCaster> make_embree_caster(const scene::StaticScene& scene, const EmbreeOptions& options);

}  // namespace ff::farfield
