#pragma once
// Parts of the tile-beam caster; its interface is make_beam_caster() of ray_caster.h.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/ray_caster.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield::beam {

/// A beam serves a square of so many pixels a side, up to four requests: twice the side costs a walk little more.
constexpr int kBeamSize = 2 * kTileSize;

/// The rays of a square as the alpha test needs them: that of (X, Y) in tile space has the direction (u, v, -1) in
/// camera space, u = X u_step + u_middle, v likewise.
struct AlphaRays {
    float pixel_angle = 0.0f;
    float u_step = 0, u_middle = 0, v_step = 0, v_middle = 0;
    float blend_within_m = 0.0f;  ///< as in PinholeView
    LeafSway sway;                ///< in the camera's axes
};

/// A pinhole view as the beams need it. Tile space: X, Y in pixels from the middle of a square of kBeamSize, right and
/// down, so that pixel centres stand at -15.5 .. 15.5; W along the view axis in metres; points as (X W, Y W, W).
struct BeamView {
    explicit BeamView(const PinholeView& pinhole);

    /// What the square whose first pixel is (x, y) tells see-through surfaces about its rays.
    [[nodiscard]] AlphaRays alpha_rays(int x, int y) const;

    /// Homogeneous tile space from world directions, for the square whose first pixel is (x, y).
    [[nodiscard]] DMat3 tile_from_world(int x, int y) const;

    PinholeView view;
    DMat3 camera_from_world;
    float pixel_angle = 0.0f;
    LeafSway sway;  ///< in the camera's axes
};

/// The requests that share a beam: quarters of a square whose first pixel has multiples of kBeamSize, null where nobody
/// asks; top left, top right, bottom left, bottom right. A pixel's tile space is the same whoever else is asked for.
struct BeamRequest {
    std::uint16_t x = 0, y = 0;
    std::array<const TileRequest*, 4> quarters{};
    float begin = 0.0f;                  ///< metres along the view axis; nearer things need not be found
    const DepthPlane* behind = nullptr;  ///< nothing nearer than this is there
};

/// Least of the depths that `out` holds at the pixels asked for.
[[nodiscard]] float least_depth(const PinholeView& view, const BeamRequest& request, const VisibilityBuffer& out);

/// A request by itself.
[[nodiscard]] BeamRequest beam_request_of(const TileRequest& tile);

/// Puts requests together; keeps its memory from call to call.
class BeamRequests {
  public:
    /// Requests beyond the view are left out. The result names `tiles` and holds until the next call.
    [[nodiscard]] std::span<const BeamRequest> gather(const PinholeView& view, std::span<const TileRequest> tiles);
    /// Takes memory for views up to this size.
    void reserve(int width, int height);

  private:
    std::vector<BeamRequest> requests_;
    std::vector<std::uint32_t> of_square_;  // index + 1 into requests_, row by row; 0: none
};

/// Resolves the pixels of one beam and writes them; adds its work to `cost`.
void cast_tile(const scene::StaticScene& scene, const BeamView& view, const BeamRequest& request, VisibilityBuffer& out,
               CastCost& cost);

/// First hit of one ray; adds its work to `cost`.
[[nodiscard]] RayHit cast_ray(const scene::StaticScene& scene, const Ray& ray, CastCost& cost);

}  // namespace ff::farfield::beam
