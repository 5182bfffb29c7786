#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/cook/gltf_mesh.h"

namespace ff::cook {

/// Decodes the attributes and indices that a KHR_draco_mesh_compression extension holds into `streams`; what it does
/// not hold stays as it is. `uv_name` is the TEXCOORD_n wanted. Indices are always a triangle list afterwards.
/// Errors: data that does not decode, or whose counts are not what the primitive's accessors say.
[[nodiscard]] Status decode_draco(const GltfData& data, const nlohmann::json& primitive, const std::string& uv_name,
                                  const std::string& place, PrimitiveStreams& streams);

}  // namespace ff::cook
