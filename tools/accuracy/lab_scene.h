#pragma once
// What the lab needs of a world that is open for drawing.

#include <functional>
#include <memory>
#include <span>

#include "engine/frame/renderer.h"
#include "engine/scene/walk.h"
#include "engine/scene/world.h"

namespace ff::accuracy {

struct LabScene {
    const scene::World& world;
    const scene::Walk& walk;
    std::span<const scene::Instance> dynamic;
    int width = 640, height = 480;
    bool has_gl = false;
    /// A renderer with a history of its own, for images of this size.
    std::function<std::unique_ptr<frame::Renderer>(int width, int height)> make_renderer;
};

}  // namespace ff::accuracy
