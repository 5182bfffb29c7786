#pragma once

#include <cstdint>

#include "engine/scene/world.h"

namespace ff::test {

/// Goes wherever a caster, the shading pass or the rasteriser may go: from the root over instances and hierarchies to
/// leaves, triangles, materials, every mip of their textures and the height grid. Every access is checked and aborts
/// when it leaves its array; so does a hierarchy that never ends.
/// @return a sum of what was seen, so that nothing is optimised away.
double touch_world(const scene::World& world);

}  // namespace ff::test
