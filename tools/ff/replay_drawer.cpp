#include "tools/ff/replay_drawer.h"

#include "engine/core/stopwatch.h"
#include "tools/ff/heap_counter.h"

namespace ff::tool {

Status ReplayDrawer::draw(host::Game& game) {
    game.show(0.0, view_);
    return draw_view(settings_);
}

Status ReplayDrawer::draw_exact(host::Game& game) {
    game.show(0.0, view_);
    return draw_view({});
}

Status ReplayDrawer::draw_from(const host::GameView& other, host::Game& game) {
    game.show(0.0, view_);
    view_.camera = other.camera;
    view_.sun = other.sun;
    view_.time_s = other.time_s;
    return draw_view(settings_);
}

Status ReplayDrawer::draw_view(const frame::FrameSettings& settings) {
    const std::uint64_t allocations = heap_allocations();
    const Stopwatch watch;
    FF_TRY(drawer_.draw(view_, size_.width, size_.height, settings, image_));
    frame_ms_ = watch.milliseconds();
    allocations_ = heap_allocations() - allocations;
    return {};
}

}  // namespace ff::tool
