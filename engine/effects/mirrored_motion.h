#pragma once
// Where mirrors may show what moves: only there is the colour that a mirror had in an earlier frame not trusted.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/effects/mirrors.h"
#include "engine/farfield/moving_shadow.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::effects {

/// Keeps of `moving` what is large enough in view that a mirror may show it: none shows it nearer than it is.
/// @param out  replaced
void find_mirrored(const PinholeView& view, std::span<const farfield::MovingSphere> moving,
                   std::vector<farfield::MovingSphere>& out);

/// Asks about the pixels of one tile after the other.
class MirroredMotion {
  public:
    /// @param moving  find_mirrored(), borrowed
    MirroredMotion(const PinholeView& view, std::span<const farfield::MovingSphere> moving)
        : view_(view), moving_(moving) {}

    /// @param x, y  its first pixel
    void begin_tile(int x, int y);

    /// Whether a mirror may show something that moves to a pixel of the tile. Never false where one does.
    /// @param plane  the mirror's, as seen by the view's eye
    [[nodiscard]] bool shows(const farfield::MirrorPlane& plane) const;

  private:
    const PinholeView& view_;
    std::span<const farfield::MovingSphere> moving_;
    DVec3 middle_{0.0};                 ///< unit: of the cone round the tile's rays
    double cosine_ = 1.0, sine_ = 0.0;  ///< of half of its angle
};

}  // namespace ff::effects
