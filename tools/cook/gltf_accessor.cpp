#include "tools/cook/gltf_accessor.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/core/jobs.h"
#include "tools/cook/gltf_validate.h"

namespace ff::cook {
namespace {

using nlohmann::json;

// Zeros by definition (no view) take no bytes of the file: a bound of their own.
constexpr std::size_t kMaxUnbackedElements = 1u << 22;

template <class T>
T read_as(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

// glTF 2.0 section 3.6.2.2: normalized integers; the signed ones clamp at -1.
float component_as_float(const std::byte* at, int type, bool normalized) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE: {
            const float value = read_as<std::int8_t>(at);
            return normalized ? std::max(value / 127.0f, -1.0f) : value;
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: {
            const float value = read_as<std::uint8_t>(at);
            return normalized ? value / 255.0f : value;
        }
        case TINYGLTF_COMPONENT_TYPE_SHORT: {
            const float value = read_as<std::int16_t>(at);
            return normalized ? std::max(value / 32767.0f, -1.0f) : value;
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
            const float value = read_as<std::uint16_t>(at);
            return normalized ? value / 65535.0f : value;
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return static_cast<float>(read_as<std::uint32_t>(at));
        default:
            return read_as<float>(at);
    }
}

std::uint32_t component_as_index(const std::byte* at, int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return read_as<std::uint8_t>(at);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return read_as<std::uint16_t>(at);
        default:
            return read_as<std::uint32_t>(at);
    }
}

// The bytes of a view that is read; a buffer without data has none.
Result<Bytes> view_bytes(const GltfData& data, int view, const std::string& place) {
    const Bytes bytes = data.views[static_cast<std::size_t>(view)];
    if (bytes.empty())
        return data.file.error(place, fmt::format("bufferViews[{}] lies in a buffer without data; expected a uri or a "
                                                  "BIN chunk",
                                                  view));
    return bytes;
}

// The elements of an accessor, packed tightly, with sparse replacements done.
Result<std::vector<std::byte>> gather(const GltfData& data, const tinygltf::Accessor& accessor,
                                      const std::string& place) {
    const std::size_t component = component_size(accessor.componentType);
    const std::size_t element = component * components_of(accessor);
    if (accessor.bufferView < 0 && accessor.count > kMaxUnbackedElements)
        return data.file.error(place, fmt::format("{} elements without a bufferView; expected at most {}",
                                                  accessor.count, kMaxUnbackedElements));
    std::vector<std::byte> packed(element * accessor.count);
    if (accessor.bufferView >= 0) {
        FF_ASSIGN(const Bytes view, view_bytes(data, accessor.bufferView, place));
        const std::size_t view_stride =
            data.model.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
        const std::size_t stride = view_stride ? view_stride : element;
        const std::byte* from = view.data() + accessor.byteOffset;
        if (stride == element)
            std::memcpy(packed.data(), from, packed.size());
        else
            for (std::size_t i = 0; i < accessor.count; ++i)
                std::memcpy(packed.data() + i * element, from + i * stride, element);
    }
    if (accessor.sparse.isSparse) {
        const auto& sparse = accessor.sparse;
        const std::size_t index_size = component_size(sparse.indices.componentType);
        FF_ASSIGN(const Bytes index_view, view_bytes(data, sparse.indices.bufferView, place));
        FF_ASSIGN(const Bytes value_view, view_bytes(data, sparse.values.bufferView, place));
        const std::byte* indices = index_view.data() + sparse.indices.byteOffset;
        const std::byte* values = value_view.data() + sparse.values.byteOffset;
        for (std::size_t i = 0; i < static_cast<std::size_t>(sparse.count); ++i) {
            const std::uint32_t index = component_as_index(indices + i * index_size, sparse.indices.componentType);
            if (index >= accessor.count)
                return data.file.error(fmt::format("{}: sparse index {}", place, i),
                                       fmt::format("{}; expected below {}", index, accessor.count));
            std::memcpy(packed.data() + index * element, values + i * element, element);
        }
    }
    return packed;
}

Result<std::vector<std::byte>> decode_meshopt(const GltfFile& file, const json& extension, const std::string& place) {
    const auto offset = extension.value("byteOffset", std::size_t{0});
    const Bytes packed = file.buffers[extension.at("buffer").get<std::size_t>()];
    const auto length = extension.at("byteLength").get<std::size_t>();
    if (packed.size() < offset + length) return file.error(place, "no bytes; expected a buffer that has some");
    const auto* source = reinterpret_cast<const unsigned char*>(packed.data() + offset);
    const auto count = extension.at("count").get<std::size_t>();
    const auto stride = extension.at("byteStride").get<std::size_t>();
    const auto mode = extension.value("mode", std::string());
    const auto filter = extension.value("filter", std::string("NONE"));
    std::vector<std::byte> decoded(count * stride);

    int failed = -1;
    if (mode == "ATTRIBUTES" && stride % 4 == 0)
        failed = meshopt_decodeVertexBuffer(decoded.data(), count, stride, source, length);
    else if (mode == "TRIANGLES" && count % 3 == 0 && (stride == 2 || stride == 4))
        failed = meshopt_decodeIndexBuffer(decoded.data(), count, stride, source, length);
    else if (mode == "INDICES" && (stride == 2 || stride == 4))
        failed = meshopt_decodeIndexSequence(decoded.data(), count, stride, source, length);
    if (failed) return file.error(place, fmt::format("mode `{}` that does not decode; expected intact data", mode));

    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
        meshopt_decodeFilterOct(decoded.data(), count, stride);
    else if (filter == "QUATERNION" && stride == 8)
        meshopt_decodeFilterQuat(decoded.data(), count, stride);
    else if (filter == "EXPONENTIAL" && stride % 4 == 0)
        meshopt_decodeFilterExp(decoded.data(), count, stride);
    else if (filter != "NONE")
        return file.error(place + ".filter",
                          fmt::format("`{}` with stride {}; expected one that fits", filter, stride));
    return decoded;
}

}  // namespace

std::size_t components_of(const tinygltf::Accessor& accessor) {
    return static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
}

Result<GltfData> open_views(const GltfFile& file, const tinygltf::Model& model) {
    GltfData data{.file = file, .model = model, .views = {}, .decoded_views = {}};
    data.decoded_views.resize(model.bufferViews.size());
    const json::json_pointer meshopt("/extensions/EXT_meshopt_compression");
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
        const tinygltf::BufferView& view = model.bufferViews[i];
        const json& source = file.json.at("bufferViews")[i];
        const std::string place = fmt::format("bufferViews[{}]", i);
        if (source.contains(meshopt)) {
            FF_ASSIGN(data.decoded_views[i],
                      decode_meshopt(file, source.at(meshopt), place + ".extensions.EXT_meshopt_compression"));
            data.views.emplace_back(data.decoded_views[i]);
            continue;
        }
        const Bytes buffer = file.buffers[static_cast<std::size_t>(view.buffer)];
        data.views.push_back(buffer.empty() ? Bytes{} : buffer.subspan(view.byteOffset, view.byteLength));
    }
    return data;
}

Result<std::vector<float>> read_floats(const GltfData& data, int accessor_index, std::size_t components,
                                       const std::string& place) {
    const tinygltf::Accessor& accessor = data.model.accessors[static_cast<std::size_t>(accessor_index)];
    if (components_of(accessor) != components)
        return data.file.error(place, fmt::format("accessor {} has {} components; expected {}", accessor_index,
                                                  components_of(accessor), components));
    FF_ASSIGN(const std::vector<std::byte> packed, gather(data, accessor, place));
    const std::size_t size = component_size(accessor.componentType);
    std::vector<float> values(accessor.count * components);
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = component_as_float(packed.data() + i * size, accessor.componentType, accessor.normalized);
        if (!std::isfinite(values[i]))
            return data.file.error(fmt::format("{}: element {}", place, i / components),
                                   fmt::format("{}; expected a finite number", values[i]));
    }
    return values;
}

Result<std::vector<std::uint32_t>> read_indices(const GltfData& data, int accessor_index, const std::string& place) {
    const tinygltf::Accessor& accessor = data.model.accessors[static_cast<std::size_t>(accessor_index)];
    const int type = accessor.componentType;
    if (components_of(accessor) != 1 ||
        (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
         type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT))
        return data.file.error(place, fmt::format("accessor {} of componentType {}; expected a scalar of 5121, 5123 "
                                                  "or 5125",
                                                  accessor_index, type));
    FF_ASSIGN(const std::vector<std::byte> packed, gather(data, accessor, place));
    const std::size_t size = component_size(type);
    std::vector<std::uint32_t> indices(accessor.count);
    for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = component_as_index(packed.data() + i * size, type);
    return indices;
}

}  // namespace ff::cook
