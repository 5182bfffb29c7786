#pragma once

#include "engine/frame/dynamic_overlay.h"
#include "engine/frame/history.h"
#include "engine/frame/plan.h"
#include "engine/frame/stats.h"
#include "engine/shading/shading_pass.h"
#include "engine/visibility/culler.h"

namespace ff::nearfield {
class NearRenderer;
}

namespace ff::frame {

/// The ray casters of a scene, each built when a plan first asks for it.
class Casters {
  public:
    explicit Casters(const scene::StaticScene& scene) : scene_(scene) {}
    /// @param grid_cells_per_item  of a grid: another number than the last makes it anew
    [[nodiscard]] farfield::RayCaster& get(CasterKind kind,
                                           double grid_cells_per_item = farfield::kUsualGridCellsPerItem);

  private:
    const scene::StaticScene& scene_;
    std::array<std::unique_ptr<farfield::RayCaster>, 3> casters_;
    double grid_cells_per_item_ = 0.0;  ///< of the grid that there is
};

/// What the passes draw with. `near_renderer` may be null where there is no OpenGL; plans then must not rasterise.
struct Tools {
    const scene::StaticScene& scene;
    Casters& casters;
    const visibility::Culler& culler;
    DynamicOverlay& dynamic_overlay;
    const farfield::LayerIndex& layer_index;
    const effects::SceneFacts& facts;
    nearfield::NearRenderer* near_renderer = nullptr;
};

/// Carries a plan out and decides nothing. Afterwards the history holds the frame's visibility and sources.
/// @param image  written whole, of the size that the plan says
FrameStats run_passes(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image);

}  // namespace ff::frame
