#pragma once
// Where the shadows of what moves may fall: only there is the light of last frame, or of the panorama, not trusted.

#include <span>

#include "engine/farfield/visibility_buffer.h"
#include "engine/math/bounds.h"
#include "engine/math/camera.h"
#include "engine/math/types.h"

namespace ff::farfield {

/// Something that moves and casts a shadow: a ball around it.
struct MovingSphere {
    WorldPos center{0.0};
    double radius = 0.0;  ///< metres
    DBox3 box;            ///< in the ball, world: where in it the thing is; empty: anywhere
};

/// Whether one of them may stand between the sun and what the requested pixels see. Never false where one does; pixels
/// without a surface are left out.
/// @param to_sun  unit, world
[[nodiscard]] bool may_be_shaded(const PinholeView& view, const VisibilityBuffer& visibility, const TileRequest& tile,
                                 std::span<const MovingSphere> moving, const Vec3& to_sun);

}  // namespace ff::farfield
