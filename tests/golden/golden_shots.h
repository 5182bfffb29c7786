#pragma once
// What the golden images show: the small town of tests/support, in every mode, from a few places.

#include <string>
#include <vector>

#include "engine/frame/renderer.h"
#include "engine/math/camera.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/scene/scene_data.h"

namespace ff::test {

struct GoldenShot {
    std::string name;  ///< of the file, without .png
    Camera camera;
    frame::FrameSettings settings;
    int turning_frames = 0;  ///< drawn before, each a little turned: the panorama is in use
};

inline constexpr int kGoldenWidth = 160, kGoldenHeight = 120;

[[nodiscard]] std::vector<GoldenShot> golden_shots();

/// Draws shots of the town. The OpenGL context must be current all the while.
class GoldenStudio {
  public:
    /// @param sun_shift  the sun is turned about the vertical by this, radians
    static Result<std::unique_ptr<GoldenStudio>> open(double sun_shift = 0.0);
    [[nodiscard]] shading::Image draw(const GoldenShot& shot);

  private:
    GoldenStudio() = default;
    scene::SceneData town_;
    scene::StaticScene scene_;
    std::unique_ptr<frame::Casters> casters_;
    std::unique_ptr<nearfield::NearRenderer> near_renderer_;
};

}  // namespace ff::test
