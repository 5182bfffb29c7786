#pragma once
// What a flat mirror shows: the view of the eye's image behind it, of which only what lies beyond the mirror counts.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/beam_caster.h"
#include "engine/farfield/ray_caster.h"

namespace ff::farfield {

/// A plane that mirrors.
struct MirrorPlane {
    Vec3 normal{0.0f, 1.0f, 0.0f};  ///< unit, world, on the side of the eye
    double height_m = 0.0;          ///< of the eye above it; > 0
};

/// The view of the eye's image. Its pixel (x, y) lies on that of the eye, so that a ray's depth is that of the way from
/// the eye to the mirror and on.
/// @param step  so many pixels of the view, along a side, are one
[[nodiscard]] PinholeView mirrored_view(const PinholeView& view, const MirrorPlane& plane, int step);

/// The mirror before that view.
/// @param lift_m  so much nearer to the eye: what the mirror is made of lies within
[[nodiscard]] DepthPlane mirror_before(const PinholeView& mirrored, const MirrorPlane& plane, double lift_m);

/// What is asked of one mirror.
struct MirrorRequest {
    PinholeView view;                    ///< mirrored_view()
    DepthPlane before;                   ///< mirror_before(); nothing nearer is met
    std::span<const TileRequest> tiles;  ///< of that view; no pixel twice, whichever the mirror
};

/// Tile beams that begin at a plane. Unlike a RayCaster's begin, which is a hint, this is strict: an eye behind a
/// water's surface stands in the ground.
/// Threads: as RayCaster.
class MirrorCaster {
  public:
    /// @param scene  looked up anew in each cast; must outlive this
    explicit MirrorCaster(const scene::StaticScene& scene) : scene_(scene) {}

    /// Takes memory for so many mirrors in views up to this size.
    void reserve(std::size_t mirrors, int width, int height);

    /// As RayCaster::cast_tiles(), for all mirrors at once: many have but a few tiles.
    CastCost cast(std::span<const MirrorRequest> mirrors, VisibilityBuffer& out);

  private:
    struct Beam {
        std::uint32_t mirror;
        beam::BeamRequest request;
    };
    const scene::StaticScene& scene_;
    std::vector<beam::BeamRequests> requests_;  // by mirror
    std::vector<beam::BeamView> views_;         // likewise
    std::vector<Beam> beams_;
};

}  // namespace ff::farfield
