#pragma once
// What answers the pixels that nothing cheaper could: one small interface for the regular grid, Embree and tile beams.

#include <cstdint>
#include <memory>
#include <span>

#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

/// A ray relative to nothing but the world: origin in double, direction of any length but 0.
struct Ray {
    WorldPos origin{0.0};
    Vec3 direction{0.0f};
};

struct RayHit {
    std::uint32_t instance = kSkyInstance;
    std::uint32_t triangle = 0;
    float t = 0.0f;  ///< in lengths of the direction; +inf for sky
};

/// A plane before a view, as its rays meet it: 1/depth = u * of_u + v * of_v + level for the ray (u, v, -1) in camera
/// space. Not positive: the ray never does.
struct DepthPlane {
    float of_u = 0.0f, of_v = 0.0f, level = 0.0f;
};

/// Work done, for the cost model; exact and repeatable.
struct CastCost {
    std::uint64_t rays = 0;
    std::uint64_t nodes = 0;      ///< BVH nodes or grid squares visited, where the caster can count them
    std::uint64_t triangles = 0;  ///< triangles tested
};

/// Finds the first hit of rays. Masked materials are respected: a texel below the cutoff is not there.
/// Threads: cast() uses the workers of jobs.h itself and may not be called from two threads at once; the result does
/// not depend on the number of workers.
class RayCaster {
  public:
    virtual ~RayCaster() = default;

    /// Answers the pixels that the tiles ask for, all of `out` else stays as it is. A pixel without a hit becomes sky.
    /// Pixels of a request beyond view.width or view.height are ignored.
    virtual CastCost cast_tiles(const PinholeView& view, std::span<const TileRequest> tiles, VisibilityBuffer& out) = 0;

    /// The same where nothing is known to stand before pixels: `out` holds at each pixel asked for a depth, in metres
    /// along the view axis, nearer than which there is nothing (0: nothing is known), and the caster need not look
    /// there. What it finds in spite of that is as good an answer.
    virtual CastCost cast_tiles_beyond(const PinholeView& view, std::span<const TileRequest> tiles,
                                       VisibilityBuffer& out) {
        return cast_tiles(view, tiles, out);
    }

    /// Answers single rays, [N] in, [N] out in the same order; a ray with a NaN is sky.
    virtual CastCost cast_rays(std::span<const Ray> rays, std::span<RayHit> hits) = 0;

    [[nodiscard]] virtual std::uint64_t memory_bytes() const = 0;
    [[nodiscard]] virtual double build_seconds() const = 0;
};

inline constexpr double kUsualGridCellsPerItem = 4.0;

/// Embree in 16-wide packets of 4 x 4 pixels; built from the scene's arrays when made.
std::unique_ptr<RayCaster> make_embree_caster(const scene::StaticScene& scene);
/// P0's regular grid, two levels (Amanatides and Woo 1987).
/// @param cells_per_item  grid cells for each triangle and each instance, > 0. More cost memory and build time, fewer
/// cost
///                        triangle tests; measured, flat between 2 and 6.
std::unique_ptr<RayCaster> make_grid_caster(const scene::StaticScene& scene,
                                            double cells_per_item = kUsualGridCellsPerItem);
/// Squares of 32 x 32 pixels at once, up to four requests, through the pack's own BVHs.
std::unique_ptr<RayCaster> make_beam_caster(const scene::StaticScene& scene);
/// The same for a scene that changes between casts: its arrays are looked up anew in each. `scene` must outlive it.
std::unique_ptr<RayCaster> make_live_beam_caster(const scene::StaticScene& scene);

}  // namespace ff::farfield
