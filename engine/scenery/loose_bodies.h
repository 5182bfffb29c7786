#pragma once
// Which of a world's models are rigid bodies, and of what shape.

#include "engine/physics/types.h"
#include "engine/scene/world.h"
#include "engine/scenery/shown_model.h"

namespace ff::scenery {

/// A loose body as the world begins. Its origin is that of its largest part, whose convex hull is its shape.
struct LooseBodyStart {
    physics::BodyDesc desc;  ///< awake: it falls to where it lies
    ShownModel model;        ///< relative to the body's origin
};
[[nodiscard]] LooseBodyStart start_of(const scene::World& world, const scene::LooseBody& body);

}  // namespace ff::scenery
