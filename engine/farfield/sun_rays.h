#pragma once
// Which pixels see the sun: one shadow ray each, towards a light at infinity, through the pack's own hierarchies.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/ray_caster.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/moving_bvh.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

/// A point that asks for the sun and is named by no pixel: of a transparent layer, of a reflection.
struct SunPoint {
    Vec3 position{0.0f};    ///< metres, relative to the origin given with it
    Vec3 normal{0.0f};      ///< unit, world, on the side of the surface that is looked at; zero: no surface, as in air
    float offset_m = 0.0f;  ///< along the normal, as sun_ray_offset()
    float footprint_m = 0.0f;  ///< width of what the point stands for: the mip that see-through surfaces are asked in
};

/// How far above its surface a shadow ray begins, metres. A hit's depth is good for about 2e-6 of itself; a vertex,
/// placed in the world and made relative to the viewer, for three roundings of the largest number it goes through,
/// 3 * 2^-24 of the mesh's reach or of the depth. The sum is left with a factor of two to spare, so that a point starts
/// above its own plane and above that of coplanar neighbours; at a distance of a kilometre it is a hundredth of what a
/// pixel covers.
/// @param depth_m  from the eye to the point
/// @param reach_m  the largest distance of the mesh's points from its origin, in the world
[[nodiscard]] inline float sun_ray_offset(float depth_m, float reach_m) {
    return 6e-6f * depth_m + 6e-7f * reach_m;
}

/// The largest distance of a mesh's points from its origin, as placed in the world, metres; a bound.
[[nodiscard]] float reach_of(const scene::Mesh& mesh, const scene::Instance& instance);

/// What stands between a scene's points and the sun.
///
/// Masked and blended surfaces cast shadows by coverage, at the footprint of the point that asks (alpha_test.h; the
/// rule beyond PinholeView::blend_within_m). A surface does not shadow itself: its own triangle is passed by, and the
/// ray begins sun_ray_offset() above it.
///
/// Threads: casts use the workers of jobs.h themselves; not to be called from two threads at once. Results and costs do
/// not depend on the number of workers. Steady calls allocate nothing.
class SunRays {
  public:
    /// @param scene  its arrays must outlive this
    explicit SunRays(const scene::StaticScene& scene);

    /// Casts a ray towards the sun from what each requested pixel sees.
    /// @param dynamic  moving instances, that the visibility buffer names by instance_count + i; they cast shadows, too
    /// @param to_sun   unit, world
    /// @param lit      [visibility.stride * visibility.rows], as VisibilityBuffer::index: 255 the sun is seen, 0 it is
    ///                 not. Only requested pixels within the view are written. Sky, and pixels that nobody has
    ///                 answered, get 255; a surface whose geometric normal, on the side that faces the viewer, looks
    ///                 away from the sun gets 0 without a ray.
    /// @return rays: those that were cast
    CastCost cast(const PinholeView& view, const VisibilityBuffer& visibility, std::span<const TileRequest> tiles,
                  std::span<const scene::Instance> dynamic, const Vec3& to_sun, std::uint8_t* lit);

    /// The same for points, [N], in any order; near ones that follow each other cost less.
    /// @param lit  [N], 255 or 0; a normal that looks away from the sun gives 0, and a not-a-number 255
    CastCost cast_points(const WorldPos& origin, std::span<const SunPoint> points,
                         std::span<const scene::Instance> dynamic, const Vec3& to_sun, std::uint8_t* lit);

    /// Makes ready for cast_tiles().
    /// @param dynamic  as in cast(); has to outlive the calls
    void begin_tiles(std::span<const scene::Instance> dynamic, const Vec3& to_sun);
    /// As cast(). Unlike it, any workers may call this at once, for tiles of their own.
    CastCost cast_tiles(const PinholeView& view, const VisibilityBuffer& visibility, std::span<const TileRequest> tiles,
                        std::uint8_t* lit) const;

  private:
    // The scene with these instances, and a tree over them, in place of its own.
    [[nodiscard]] const scene::StaticScene& moving(std::span<const scene::Instance> dynamic);

    scene::StaticScene scene_;
    scene::StaticScene moving_;
    scene::MovingBvh moving_bvh_;
    Vec3 to_sun_{0.0f, 1.0f, 0.0f};  // of cast_tiles()
};

}  // namespace ff::farfield
