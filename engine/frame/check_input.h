#pragma once
// The border at which numbers enter a frame: what no picture can be drawn of is refused here, with a message, so that
// nothing behind it need look again.

#include <span>

#include "engine/core/result.h"
#include "engine/frame/settings.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::frame {

/// Metres from the world's origin within which a camera or a moving instance may stand: a double is exact to 0.1 mm
/// there.
inline constexpr double kMaxCoordinateM = 1e12;

/// @param dynamic  as for Renderer::draw
/// @return which number of camera, instances or settings is not finite or out of its range, and what was expected
[[nodiscard]] Status check_frame_input(const scene::StaticScene& scene, const Camera& camera,
                                       std::span<const scene::Instance> dynamic, const FrameSettings& settings);

}  // namespace ff::frame
