#pragma once
// Two ways through the same grids. Single rays walk cell by cell (Amanatides, Woo, "A Fast Voxel Traversal Algorithm
// for Ray Tracing", Eurographics 1987). Rays of one viewer go together, slice by slice of the grid along their main
// axis (Wald, Ize, Kensler, Knoll, Parker, "Ray Tracing Animated Scenes using Coherent Grid Traversal", SIGGRAPH 2006):
// the walk is then paid once for all of them, and each triangle is tested against all at once.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/grid_structure.h"
#include "engine/farfield/ray_caster.h"

namespace ff::farfield::grid {

/// How an instance's rays come into its mesh's space.
struct Placement {
    Mat3 mesh_from_world{1.0f};
    bool is_turned = false;  ///< mesh_from_world is not the identity
};

/// The grids and what they refer to.
struct GridWorld {
    scene::StaticScene scene;
    Grid top;
    std::vector<Grid> meshes;           ///< per mesh
    std::vector<Placement> placements;  ///< per instance
};

/// What the alpha test wants to know of a ray (alpha_test.h); nothing, for a bare one.
struct RayCone {
    float pixel_angle = 0.0f;
    float layer_depth = 0.0f;        ///< blended hits with a smaller t are transparent layers
    const LeafSway* sway = nullptr;  ///< of the view whose eye the ray starts at
};

/// First hit of one ray. Directions with a NaN or of length 0 hit nothing.
[[nodiscard]] RayHit cast_ray(const GridWorld& world, const Ray& ray, const RayCone& cone, CastCost& cost);

/// Answers the pixels of some tiles.
[[nodiscard]] CastCost cast_packets(const GridWorld& world, const PinholeView& view, std::span<const TileRequest> tiles,
                                    VisibilityBuffer& out);

}  // namespace ff::farfield::grid
