#pragma once
// From what a game shows to a picture.

#include "engine/animation/dynamic_models.h"
#include "engine/frame/renderer.h"
#include "engine/host/game.h"

namespace ff::host {

class ViewDrawer {
  public:
    /// Borrows all; they must outlive it. Poses the world's models from now on.
    /// @param near_renderer  may be null where there is no OpenGL
    ViewDrawer(scene::World& world, nearfield::NearRenderer* near_renderer);

    /// Draws at this size; a change of it forgets all earlier frames. Errors: what Renderer refuses.
    Status draw(const GameView& view, int width, int height, const frame::FrameSettings& settings,
                shading::Image& image);
    /// Forgets all earlier frames, as after a teleport.
    void reset();

    /// Of the last frame.
    [[nodiscard]] const frame::FrameStats& stats() const { return stats_; }
    [[nodiscard]] const frame::Renderer& renderer() const { return *renderer_; }

  private:
    scene::World& world_;
    nearfield::NearRenderer* near_renderer_;
    frame::Casters casters_;
    animation::DynamicModels models_;
    std::unique_ptr<frame::Renderer> renderer_;
    int width_ = 0, height_ = 0;
    std::vector<scene::Instance> dynamic_;
    frame::FrameStats stats_;
};

}  // namespace ff::host
