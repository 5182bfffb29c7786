#pragma once

#include "engine/scene/static_scene.h"

namespace ff::scene {

/// The world box around a mesh-space box of an instance; empty for an empty box.
[[nodiscard]] DBox3 world_box(const Instance& instance, const Box3& box);

}  // namespace ff::scene
