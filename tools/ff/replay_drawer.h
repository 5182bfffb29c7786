#pragma once
// The frames of a recorded session, as replay and compare draw them.

#include "engine/host/replay_session.h"
#include "engine/host/view_drawer.h"
#include "tools/ff/commands.h"

namespace ff::tool {

inline constexpr int kReplayFramesPerSecond = 30;
/// A frame is drawn before each tick whose number is a multiple of this.
inline constexpr std::uint64_t kTicksPerFrame = host::kTicksPerSecond / kReplayFramesPerSecond;

class ReplayDrawer {
  public:
    /// Borrows the world; poses its models from now on.
    ReplayDrawer(scene::World& world, const ImageSize& size, double budget_ms) : drawer_(world, nullptr), size_(size) {
        settings_.budget_ms = budget_ms;
    }

    /// What the game shows now. Errors: what the renderer refuses.
    Status draw(host::Game& game);
    /// The same exactly, whatever the time per frame.
    Status draw_exact(host::Game& game);
    /// The same from where somebody else stands, in his light: of a session in another world.
    Status draw_from(const host::GameView& other, host::Game& game);
    /// Forgets all earlier frames.
    void reset() { drawer_.reset(); }

    // Of the last frame.
    [[nodiscard]] double frame_ms() const { return frame_ms_; }  ///< posing what moves included
    [[nodiscard]] std::uint64_t allocations() const { return allocations_; }
    [[nodiscard]] const frame::FrameStats& stats() const { return drawer_.stats(); }
    [[nodiscard]] const frame::FramePlan& plan() const { return drawer_.renderer().plan(); }
    [[nodiscard]] const host::GameView& view() const { return view_; }
    [[nodiscard]] const shading::Image& image() const { return image_; }

  private:
    Status draw_view(const frame::FrameSettings& settings);

    host::ViewDrawer drawer_;
    ImageSize size_;
    frame::FrameSettings settings_;
    host::GameView view_;
    shading::Image image_;
    double frame_ms_ = 0.0;
    std::uint64_t allocations_ = 0;
};

}  // namespace ff::tool
