#pragma once
// Where the shadows of what moves may fall: only there is the light of last frame, or of the panorama, not trusted.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

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

/// The shadows of all that moves, made ready to be asked about one tile after the other.
/// Threads: find() may be called by any number at once. Steady calls allocate nothing.
class MovingShadows {
  public:
    /// @param view    of the tiles that will be asked about; copied
    /// @param to_sun  unit, world
    void begin(const PinholeView& view, std::span<const MovingSphere> moving, const Vec3& to_sun);

    [[nodiscard]] bool is_empty() const { return count_ == 0; }

    /// Whether a shadow may fall on anything that a tile's pixels may see, at whatever depth that lies. Never false
    /// where one does.
    [[nodiscard]] bool may_fall_into(const TileRequest& tile) const;

    /// Leaves in a request the pixels that one of them may stand before the sun of: all of those whose surfaces it
    /// does shade, and some round them.
    /// @return whether there are any
    [[nodiscard]] bool find(const VisibilityBuffer& visibility, TileRequest& tile) const;

    /// Columns of numbers a caster: its centre's cross product with the sun's direction, which is where its shadow's
    /// axis lies; how far towards the sun it stands; what its box takes up round the axis, and its ball. Then, in the
    /// plane across the sun, where the direction (unit) of that axis lies as seen by the eye, the sine and cosine of
    /// the angle that the ball takes up there, its least and greatest distance, and how far towards the sun it reaches.
    enum Column {
        axis_x,
        axis_y,
        axis_z,
        along,
        half_x,
        half_y,
        half_z,
        radius,
        to_axis_s,
        to_axis_t,
        ball_sine,
        ball_cosine,
        least_distance,
        most_distance,
        reach,
        column_count
    };

  private:
    PinholeView view_;
    Vec3 to_sun_{0.0f};
    DVec3 across_[2]{};                                  // axes of the plane across the sun
    std::size_t count_ = 0;                              // of casters; columns are padded to whole vectors
    std::array<std::vector<float>, column_count> data_;  // metres, relative to the eye
};

}  // namespace ff::farfield
