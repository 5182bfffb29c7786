#pragma once
// Parts of the tile-beam caster; its interface is make_beam_caster() of ray_caster.h.

#include <cstdint>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/ray_caster.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield::beam {

/// The rays of a tile as the alpha test needs them: that of (X, Y) in tile space has the direction (u, v, -1) in camera
/// space, u = X u_step + u_middle, v likewise.
struct AlphaRays {
    float pixel_angle = 0.0f;
    float u_step = 0, u_middle = 0, v_step = 0, v_middle = 0;
    float blend_within_m = 0.0f;  ///< as in PinholeView
};

/// A pinhole view as the tiles need it. Tile space: X, Y in pixels from the tile's middle, right and down, so that
/// pixel centres stand at -7.5 .. 7.5; W along the view axis in metres; points as (X W, Y W, W).
struct BeamView {
    explicit BeamView(const PinholeView& pinhole);

    /// What the tile whose first pixel is (x, y) tells see-through surfaces about its rays.
    [[nodiscard]] AlphaRays alpha_rays(int x, int y) const;

    /// Homogeneous tile space from world directions, for the tile whose first pixel is (x, y).
    [[nodiscard]] DMat3 tile_from_world(int x, int y) const;

    PinholeView view;
    DMat3 camera_from_world;
    float pixel_angle = 0.0f;
};

/// Resolves one tile and writes its pixels; adds its work to `cost`.
void cast_tile(const scene::StaticScene& scene, const BeamView& view, const TileRequest& request, VisibilityBuffer& out,
               CastCost& cost);

/// First hit of one ray; adds its work to `cost`.
[[nodiscard]] RayHit cast_ray(const scene::StaticScene& scene, const Ray& ray, CastCost& cost);

}  // namespace ff::farfield::beam
