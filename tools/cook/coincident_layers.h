#pragma once
// Which surfaces that lie in one plane go in front of which, and how far each is moved.

#include <cstdint>
#include <span>
#include <vector>

#include "tools/cook/coincident_pairs.h"

namespace ff::cook {

/// No patch.
inline constexpr std::uint32_t kNoPatch = ~0u;

/// Triangles of one mesh that move together: neighbours in one plane, or an instance as a whole.
struct CoincidentPatch {
    std::uint32_t slot = 0;       ///< PlacedTriangles::slots
    bool whole_instance = false;  ///< moves its placement; else its triangles
    DVec3 normal{0.0};            ///< unit, the side that the triangles face
    DVec3 offset{0.0};            ///< how far it moves, world metres
};

struct CoincidentLayers {
    std::vector<CoincidentPatch> patches;
    std::vector<std::uint32_t> patch_of;  ///< of each triangle that moves by itself, kNoPatch else
};

/// Puts the surfaces of `pairs` in order. Where two face the same way, the later in the source comes in front, as a
/// depth test of less-or-equal shows them; what has holes or is transparent comes in front of what is opaque. Where
/// they face opposite ways, each comes in front on its own side. The lowest of a stack stays where it is; each further
/// one moves by a step of at most kMostStepM, less for patches smaller than a hundred steps, never less than float32
/// can hold. Stacks deeper than kMostLayers reuse layers between surfaces that do not overlap each other.
[[nodiscard]] CoincidentLayers order_coincident(const PlacedTriangles& triangles,
                                                std::span<const scene::Material> materials,
                                                std::span<const CoincidentPair> pairs);

inline constexpr double kMostStepM = 1.5e-3;  ///< below a pixel from 1 m on (60 degrees over 480 pixels)
inline constexpr int kMostLayers = 4;

}  // namespace ff::cook
