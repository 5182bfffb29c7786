#pragma once
// Which models are foliage, that wind moves.

#include "tools/cook/gltf_import.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Lets the wind move a model's masked materials (scene::kMaterialSways), those of its meshes as they are placed and of
/// what it is animated by. Its other materials, trunks say, stand still. Twice does what once does.
void mark_foliage(const Model& model, WorldSource& world);

}  // namespace ff::cook
