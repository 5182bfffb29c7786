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
    /// What moves, at a frame of the walk; good until the next call. Empty: nothing does.
    std::function<std::span<const scene::Instance>(std::size_t walk_frame)> moving;
    int width = 640, height = 480;
    bool has_gl = false;
    /// A renderer with a history of its own, for images of this size.
    std::function<std::unique_ptr<frame::Renderer>(int width, int height)> make_renderer;

    [[nodiscard]] std::span<const scene::Instance> dynamic(std::size_t walk_frame) const {
        return moving ? moving(walk_frame) : std::span<const scene::Instance>();
    }
};

}  // namespace ff::accuracy
