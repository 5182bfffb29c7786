#pragma once

#include "engine/math/bounds.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Adds copies of everything static until it is there `count` times: on a grid around the original, nearest squares
/// first, a gap of a twentieth between them. Copies are geometry of their own, in the pack as in the source: a mesh
/// with instances is stored once a copy.
/// @param bounds  of the original
void copy_static_content(WorldSource& world, const DBox3& bounds, int count);

}  // namespace ff::cook
