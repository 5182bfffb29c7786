#pragma once
// Points that ask for the sun together, and the space in which that is simple. Sun rays are parallel: in light space
// (s, t across the light, d towards it, metres) a ray is a point (s, t), and what hides the sun from it covers (s, t)
// at a greater d.

#include <cstdint>

#include "engine/farfield/ray_caster.h"
#include "engine/math/types.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield::sun {

/// Axes of light space, orthonormal: s x t = d.
struct LightFrame {
    explicit LightFrame(const Vec3& to_sun);
    DVec3 s, t, d;
};

/// Up to 64 points, so that a set of them is a word. Entries beyond `count` are those of the last point.
struct PointGroup {
    static constexpr int kMost = 64;
    int count = 0;
    WorldPos centre{0.0};                                                ///< light space has its origin here
    alignas(64) float s[kMost], t[kMost], d[kMost];                      ///< already above their surfaces
    alignas(64) float footprint[kMost];                                  ///< metres; for the alpha test
    alignas(64) std::uint32_t own_instance[kMost], own_triangle[kMost];  ///< that do not shadow the point
    std::uint64_t left = 0;                                              ///< points that nothing hides so far
};

/// Leaves that hid much of a group, the last one first: they mostly hide its neighbours, too.
struct Occluders {
    static constexpr int kMost = 2;
    struct Leaf {
        std::uint32_t instance, leaf;
    };
    int count = 0;
    Leaf leaves[kMost];
};

/// Takes from group.left what the scene's instances hide; adds its work to `cost`.
/// @param first_id   name of the scene's first instance in own_instance
/// @param occluders  of this scene; kept from group to group. They change the order of tests alone.
void cast_group(const scene::StaticScene& scene, std::uint32_t first_id, const LightFrame& light, Occluders& occluders,
                PointGroup& group, CastCost& cost);

}  // namespace ff::farfield::sun
