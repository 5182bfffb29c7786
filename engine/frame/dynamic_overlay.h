#pragma once

#include <memory>
#include <span>

#include "engine/farfield/mirror_caster.h"
#include "engine/farfield/pixel_mask.h"
#include "engine/farfield/ray_caster.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/frame/moving_tiles.h"
#include "engine/math/camera.h"
#include "engine/scene/moving_bvh.h"
#include "engine/scene/static_scene.h"

namespace ff::frame {

/// Instances that move, at any distance: cast by tile beams through a small tree of their own and depth-tested against
/// what the static world shows, however that was found. So neither panorama nor horizon need know of them. Only tiles
/// that an instance's box may show in are looked at. Steady frames allocate nothing.
class DynamicOverlay {
  public:
    explicit DynamicOverlay(const scene::StaticScene& scene);
    DynamicOverlay(const DynamicOverlay&) = delete;
    DynamicOverlay& operator=(const DynamicOverlay&) = delete;

    /// Puts the instances that are nearer than the depths in `visibility` there; ids from the scene's instance count
    /// on.
    /// @param tiles    all tiles of the view
    /// @param covered  sized to the view; set where an instance now shows, else left
    /// @param behind   if given, nothing nearer than this plane is there
    /// @return the work done
    farfield::CastCost draw(const PinholeView& view, std::span<const scene::Instance> dynamic,
                            std::span<const farfield::TileRequest> tiles, farfield::VisibilityBuffer& visibility,
                            farfield::PixelMask& covered, const farfield::DepthPlane* behind = nullptr);

    /// Makes room for views up to this size.
    void reserve(int width, int height) { visibility_.resize(width, height); }

    /// The scene with the instances of the last draw, and a tree over them, in place of the static ones.
    [[nodiscard]] const scene::StaticScene& moving() const { return scene_; }

  private:
    scene::StaticScene scene_;  ///< the static arrays, with the moving instances in place of the others
    std::uint32_t first_id_;
    scene::MovingBvh tree_;
    std::unique_ptr<farfield::RayCaster> caster_;  ///< of scene_
    farfield::MirrorCaster behind_;                ///< likewise
    MovingTiles tiles_;
    farfield::VisibilityBuffer visibility_;
};

}  // namespace ff::frame
