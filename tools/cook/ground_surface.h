#pragma once
// The topmost upward-facing surface of static models, where a scene has no terrain (formats.md, "the ground").

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "tools/cook/world_source.h"

namespace ff::cook {

class GroundSurface {
  public:
    /// Takes the triangles of the static placements [first, end).
    GroundSurface(const WorldSource& world, std::size_t first, std::size_t end);

    /// Height of the topmost surface that faces up at (x, z); nullopt where there is none.
    [[nodiscard]] std::optional<double> height_at(double x, double z) const;
    [[nodiscard]] std::size_t triangle_count() const { return triangles_.size(); }

  private:
    struct Triangle {
        DVec3 a, b, c;
    };
    std::vector<Triangle> triangles_;
    double low_x_ = 0, low_z_ = 0, square_m_ = 1;
    int columns_ = 0, rows_ = 0;
    std::vector<std::uint32_t> first_;    ///< per square, into members_; one more at the end
    std::vector<std::uint32_t> members_;  ///< triangles whose boxes meet the square
};

/// The ground of a world that is still being built: each model may stand on those before it.
class GrowingGround {
  public:
    /// Adds the placements up to `end` that came since the last call. All calls together take n log n in the triangles,
    /// however many they are.
    void update(const WorldSource& world, std::size_t end);
    /// Not itself: a list of surfaces that stays as it is now. Threads: any number may ask it.
    [[nodiscard]] std::function<std::optional<double>(double x, double z)> now() const;

  private:
    struct Part {
        std::size_t first = 0, end = 0;  ///< placements
        std::shared_ptr<const GroundSurface> surface;
    };
    std::vector<Part> parts_;  ///< each has more than twice the triangles of the next
};

}  // namespace ff::cook
