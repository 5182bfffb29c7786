#pragma once

#include "engine/scene/static_scene.h"

namespace ff::scene {

/// The world box around a mesh-space box of an instance; empty for an empty box.
[[nodiscard]] DBox3 world_box(const Instance& instance, const Box3& box);

/// A world box relative to a point, rounded outwards.
[[nodiscard]] Box3 relative_box(const DBox3& box, const WorldPos& origin);

}  // namespace ff::scene
