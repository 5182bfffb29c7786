#pragma once
// What a pixel must show, by brute force in long double: every triangle of every instance. For small scenes.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"
#include "tests/hardcases/hard_case.h"

namespace ff::hardcases {

using LVec3 = glm::vec<3, long double>;

struct PixelRules {
    /// A pixel nearer than this to an edge may show either side of it, pixels.
    double edge_px = 0.01;
    /// Triangles whose depths differ by less, relatively, may win either way.
    double depth = 1e-5;
    /// Whether another triangle of the very plane may show instead: what cannot be told from the surface.
    bool any_of_plane = false;
};

class ExactPixels {
  public:
    ExactPixels(const scene::StaticScene& scene, const PinholeView& view, const PixelRules& rules);

    /// Counts each pixel of the view: whether what is seen may be seen there, and by how much its depth is off,
    /// relatively.
    void count(const farfield::VisibilityBuffer& seen, Trial& trial) const;

  private:
    struct Triangle {
        std::uint32_t instance, triangle;
        LVec3 corner[3];  ///< relative to the eye
        LVec3 normal;     ///< as long as twice the area
        long double height, nearest_m, farthest_m;
    };
    /// Where a ray crosses a triangle's plane.
    struct Crossing {
        long double depth;   ///< along the view axis; of direction lengths
        long double inside;  ///< least barycentric coordinate
        long double doubt;   ///< how much of it rules.edge_px may make
    };
    [[nodiscard]] Crossing cross(const Triangle& triangle, const LVec3& direction) const;
    [[nodiscard]] std::string problem(int x, int y, const farfield::VisibilityBuffer& seen, double& error) const;

    PinholeView view_;
    PixelRules rules_;
    std::vector<Triangle> triangles_;
    std::vector<std::size_t> first_of_instance_;
};

}  // namespace ff::hardcases
