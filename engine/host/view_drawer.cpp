#include "engine/host/view_drawer.h"

#include <cmath>

namespace ff::host {
namespace {

Vec3 direction_to(const SunPosition& sun) {
    const double level = std::cos(sun.elevation);
    return Vec3(level * std::sin(sun.azimuth), std::sin(sun.elevation), -level * std::cos(sun.azimuth));
}

}  // namespace

ViewDrawer::ViewDrawer(scene::World& world, nearfield::NearRenderer* near_renderer)
    : world_(world), near_renderer_(near_renderer), casters_(world.scene()), models_(world) {}

void ViewDrawer::reset() {
    if (renderer_) renderer_->reset();
}

Status ViewDrawer::draw(const GameView& view, int width, int height, const frame::FrameSettings& settings,
                        shading::Image& image) {
    if (!renderer_ || width != width_ || height != height_) {
        width_ = width;
        height_ = height;
        renderer_ = std::make_unique<frame::Renderer>(world_.scene(), casters_, near_renderer_, width, height);
    }
    const auto posed = models_.pose(view.models, make_view(view.camera, width, height));
    dynamic_.assign(view.dynamic.begin(), view.dynamic.end());
    dynamic_.insert(dynamic_.end(), posed.begin(), posed.end());
    frame::FrameSettings now = settings;
    now.time_s = view.time_s;
    now.hearing.is_called_for = !world_.info().sounds.clips.empty();
    now.simulations = view.simulations;
    if (view.sun) now.to_sun = direction_to(*view.sun);
    stats_ = renderer_->draw(view.camera, dynamic_, now, image);
    return renderer_->refusal();
}

}  // namespace ff::host
