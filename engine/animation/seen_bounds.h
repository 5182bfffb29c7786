#pragma once

#include "engine/math/bounds.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"
#include "engine/visibility/frustum.h"

namespace ff::animation {

/// Whether what lies in a box may be seen in a view, or its shadow may. Conservative.
class SeenBounds {
  public:
    SeenBounds(const scene::StaticScene& scene, const PinholeView& view);

    [[nodiscard]] bool may_matter(const DBox3& box) const;

  private:
    visibility::Frustum frustum_;
    double pixel_angle_;
    bool has_shadows_;
    DVec3 to_sun_;
    double floor_y_;  ///< below there is nothing for a shadow to fall on
    double reach_m_;  ///< of the scene
};

}  // namespace ff::animation
