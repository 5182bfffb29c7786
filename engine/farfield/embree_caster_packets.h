#pragma once
// The inner loop of the Embree caster: pixels to packets, packets to Embree, hits to the visibility buffer.

#include <embree3/rtcore.h>

#include <cstdint>
#include <span>

#include "engine/farfield/ray_caster.h"

namespace ff::farfield::embree {

/// What all packets of one cast_tiles call share.
struct PacketJob {
    RTCScene scene = nullptr;
    const PinholeView* view = nullptr;
    Vec3 origin{0.0f};  ///< of the rays, relative to the Embree scene's origin
    VisibilityBuffer* out = nullptr;
    int packet_width = 16;  ///< 8 or 16
    bool beyond = false;    ///< rays begin at the depths that `out` holds
};

/// Answers the pixels of some tiles.
/// @return rays cast.
std::uint64_t cast_packets(const PacketJob& job, std::span<const TileRequest> tiles);

}  // namespace ff::farfield::embree
