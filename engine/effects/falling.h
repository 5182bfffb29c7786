#pragma once
// Rain and snow in the air near the viewer: streaks and flakes over the shaded picture, where nothing stands before
// them and no roof above.

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/farfield/ray_caster.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/environment.h"
#include "engine/shading/shading_pass.h"

namespace ff::effects {

/// Side of the cube round the eye in which drops and flakes are drawn, metres.
inline constexpr double kFallSideM = 16.0;

/// The highest thing under the sky of each square metre round the viewer: below it nothing falls. A ray down from the
/// sky for each square, cast when the viewer comes near it and kept while he is.
class Shelter {
  public:
    Shelter();
    /// Casts rays of squares that are not known yet, the nearest first.
    /// @return rays cast, at most kRaysAFrame
    std::uint64_t update(const WorldPos& eye, farfield::RayCaster& caster);
    /// Height of what is highest there, metres; +inf where that is not known, -inf where there is nothing.
    [[nodiscard]] float top_at(double x, double z) const;
    void clear();

    static constexpr int kSide = 18;  ///< squares: a few more than the cube has
    static constexpr std::uint64_t kRaysAFrame = 96;

  private:
    struct Square {
        std::int64_t x = std::numeric_limits<std::int64_t>::max(), z = 0;
        float top = 0.0f;
    };
    [[nodiscard]] static std::size_t index_of(std::int64_t x, std::int64_t z);
    std::array<Square, std::size_t(kSide* kSide)> squares_;
    std::vector<farfield::Ray> rays_;
    std::vector<farfield::RayHit> hits_;
};

/// What falls in one frame.
struct Fall {
    scene::Weather weather;
    double time_s = 0.0;   ///< any clock of the game's; the same time gives the same drops
    float density = 1.0f;  ///< share of the drops and flakes that are drawn. [0, 1]
    Vec3 light{1.0f};      ///< linear colour of what falls
    bool by_film = false;  ///< how the picture holds it: as shading::encode_color
};

/// Draws what falls over an image. Stateless: where drops are follows from their number and the time alone.
/// @return drops and flakes that show
std::uint64_t draw_fall(const Fall& fall, const PinholeView& view, const farfield::VisibilityBuffer& visible,
                        const Shelter& shelter, shading::Image& out);

}  // namespace ff::effects
