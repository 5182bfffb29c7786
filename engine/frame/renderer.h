#pragma once

#include <span>

#include "engine/core/result.h"
#include "engine/frame/run_passes.h"

namespace ff::frame {

/// Frame after frame of one world at one image size: plans, carries out, learns the costs. What a game's loop calls.
/// Threads: one; the passes use the workers of jobs.h.
class Renderer {
  public:
    static constexpr int kMaxSidePx = 16384;  ///< of an image

    /// Borrows all; they must outlive it.
    /// @param near_renderer  may be null where there is no OpenGL
    /// @param width, height  of the image, [1, kMaxSidePx]
    Renderer(const scene::StaticScene& scene, Casters& casters, nearfield::NearRenderer* near_renderer, int width,
             int height);

    /// Draws one frame. The first frame of a mode may build its caster, which takes as long as it takes.
    /// Numbers that no picture can be drawn of (check_input.h) are refused: image and history stay as they are, the
    /// stats say that nothing was drawn, and refusal() why.
    const FrameStats& draw(const Camera& camera, std::span<const scene::Instance> dynamic,
                           const FrameSettings& settings, shading::Image& image);

    /// What lies in the box has changed, or did before: call it with the old and the new box of an edit. Whatever
    /// earlier frames know of pixels whose rays meet it is forgotten.
    void region_changed(const DBox3& box);

    /// Forgets all earlier frames, as after a teleport or before a new lap of a bench.
    void reset();

    /// Success, or why the last frame was not drawn.
    [[nodiscard]] const Status& refusal() const { return refusal_; }
    [[nodiscard]] const FramePlan& plan() const { return plan_; }
    [[nodiscard]] const FrameHistory& history() const { return history_; }

  private:
    const FrameStats& refuse(Error reason, shading::Image& image);

    const scene::StaticScene& source_;
    scene::StaticScene drawn_;  ///< the same in this frame's light and air
    visibility::Culler culler_;
    DynamicOverlay dynamic_overlay_;
    farfield::LayerIndex layer_index_;
    effects::LampGrid lamps_;
    std::vector<DBox3> water_, mirrors_;
    effects::SceneFacts facts_;
    Tools tools_;
    int width_, height_;
    FrameHistory history_;
    FramePlan plan_;
    FrameStats refused_stats_;
    Status refusal_;
};

}  // namespace ff::frame
