#pragma once
// Everything in a glTF document that later steps rely on without looking again: indices in range, accessors inside
// their views, views inside their buffers, a node graph that is a forest, known extensions.

#include "engine/core/result.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/gltf_file.h"

namespace ff::cook {

/// Checks a document before anything is loaded for it. Optional extensions that are not read are warned about.
/// Errors: the first break, with its place, e.g. `meshes[3].primitives[0].attributes.POSITION: 17; expected an index
/// below 12`.
[[nodiscard]] Status validate_gltf(const GltfFile& file, CookContext& context);

/// Bytes of one component of an accessor's componentType; 0 for an unknown one.
[[nodiscard]] std::size_t component_size(int component_type);
/// Components of an accessor's type (SCALAR, VEC2, ...); 0 for an unknown one.
[[nodiscard]] std::size_t component_count(const std::string& type);

}  // namespace ff::cook
