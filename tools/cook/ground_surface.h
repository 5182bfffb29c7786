#pragma once
// The topmost upward-facing surface of static models, where a scene has no terrain (formats.md, "the ground").

#include <optional>
#include <vector>

#include "tools/cook/world_source.h"

namespace ff::cook {

class GroundSurface {
  public:
    /// Takes the triangles of all static placements that are there now.
    explicit GroundSurface(const WorldSource& world);

    /// Height of the topmost surface that faces up at (x, z); nullopt where there is none.
    [[nodiscard]] std::optional<double> height_at(double x, double z) const;

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

}  // namespace ff::cook
