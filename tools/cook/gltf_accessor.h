#pragma once
// Numbers out of accessors: any component type and stride, normalized or not, sparse or not, from plain or
// meshopt-compressed views.

#include <cstdint>
#include <string>
#include <vector>

#include "tools/cook/gltf_parse.h"

namespace ff::cook {

/// What mesh readers need together; borrowed. All of it has passed validate_gltf.
struct GltfData {
    const GltfFile& file;
    const tinygltf::Model& model;
    std::vector<Bytes> views;  ///< bytes of each bufferView, decoded
    std::vector<std::vector<std::byte>> decoded_views;
};

/// Resolves the views, decoding those that EXT_meshopt_compression holds.
[[nodiscard]] Result<GltfData> open_views(const GltfFile& file, const tinygltf::Model& model);

/// Elements as floats, `components` each. Integers are scaled to [0, 1] or [-1, 1] if the accessor says normalized,
/// else converted. @param place for messages.
/// Errors: another number of components than expected; sparse indices out of range; NaN or infinity.
[[nodiscard]] Result<std::vector<float>> read_floats(const GltfData& data, int accessor, std::size_t components,
                                                     const std::string& place);

/// Scalar unsigned integers. Errors: another type.
[[nodiscard]] Result<std::vector<std::uint32_t>> read_indices(const GltfData& data, int accessor,
                                                              const std::string& place);

/// Components of an accessor's elements.
[[nodiscard]] std::size_t components_of(const tinygltf::Accessor& accessor);

}  // namespace ff::cook
