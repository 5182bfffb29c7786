#pragma once
// From pixels to the points that ask for the sun.

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/farfield/sun_group.h"
#include "engine/farfield/sun_rays.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield::sun {

/// Points of a few tiles, neighbours beside each other; light space relative to the eye.
struct PointPool {
    static constexpr int kTiles = 4;
    static constexpr int kMost = kTiles * kTileSize * kTileSize;
    int count = 0;
    // With room for a register that is stored beyond the last.
    static constexpr int kRoom = kMost + 16;
    float s[kRoom], t[kRoom], d[kRoom];  // already above their surfaces
    float footprint[kRoom];
    std::uint32_t own_instance[kRoom], own_triangle[kRoom];
    std::uint32_t answer[kRoom];  ///< index into `lit`
};

/// Answers the pixels of a tile that need no ray, and adds the others to the pool, which has room for a tile.
/// @param dynamic  instances from scene.instances.size() on
void gather_tile(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic, const PinholeView& view,
                 const LightFrame& light, const VisibilityBuffer& visibility, const TileRequest& tile,
                 std::uint8_t* lit, PointPool& pool);

/// Adds a point to the pool, which has room for it, or answers it where it needs no ray.
void gather_point(const SunPoint& point, std::uint32_t answer, const LightFrame& light, std::uint8_t* lit,
                  PointPool& pool);

/// Makes a group of up to PointGroup::kMost points from `first` on; returns how many. Its centre is the first.
int make_group(const PointPool& pool, int first, const WorldPos& eye, const LightFrame& light, PointGroup& group);

}  // namespace ff::farfield::sun
