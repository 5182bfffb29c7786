#include "tools/cook/gltf_draco.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace ff::cook {
namespace {

// The counts at the head of a Draco mesh (bitstream specification 2.2, sections 3 and 4). Draco allocates by them
// before it looks at the data, so they are held against the file first.
struct DracoCounts {
    std::uint64_t faces = 0;
    bool known = false;  // not behind a metadata block
};

Result<DracoCounts> read_counts(const GltfFile& file, Bytes bytes, const std::string& place) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
    if (bytes.size() < 14 || std::string_view(reinterpret_cast<const char*>(bytes.data()), 5) != "DRACO")
        return file.error(place, "no Draco header; expected one");
    if (byte(5) != 2 || byte(6) != 2)
        return file.error(place, fmt::format("bitstream {}.{}; expected 2.2", byte(5), byte(6)));
    if (byte(7) != 1 || byte(8) > 1)
        return file.error(place, fmt::format("encoder type {} method {}; expected a mesh", byte(7), byte(8)));
    if (byte(10) & 0x80) return DracoCounts{};  // METADATA_FLAG_MASK
    std::size_t at = 11;
    const auto varint = [&] {
        std::uint64_t value = 0;
        for (int shift = 0; at < bytes.size() && shift < 63; shift += 7) {
            const std::uint8_t b = byte(at++);
            value |= static_cast<std::uint64_t>(b & 0x7F) << shift;
            if (!(b & 0x80)) break;
        }
        return value;
    };
    if (byte(8) == 1) {
        ++at;      // traversal decoder
        varint();  // vertices
    }
    return DracoCounts{.faces = varint(), .known = true};
}

std::vector<float> read_attribute(draco::Mesh& mesh, int attribute_id, bool normalized, std::size_t components) {
    draco::PointAttribute& attribute = *mesh.attribute(attribute_id);
    attribute.set_normalized(normalized);  // the accessor's word counts, not the encoder's
    std::vector<float> values(std::size_t{mesh.num_points()} * components, 0.0f);
    for (draco::PointIndex p(0); p < mesh.num_points(); ++p)
        attribute.ConvertValue<float>(attribute.mapped_index(p), static_cast<std::int8_t>(components),
                                      values.data() + std::size_t{p.value()} * components);
    return values;
}

Status decode(const GltfData& data, const nlohmann::json& primitive, const std::string& uv_name,
              const std::string& place, PrimitiveStreams& streams) {
    const GltfFile& file = data.file;
    const nlohmann::json& extension = primitive.at("extensions").at("KHR_draco_mesh_compression");
    const Bytes bytes = data.views[extension.at("bufferView").get<std::size_t>()];
    FF_ASSIGN(const DracoCounts counts, read_counts(file, bytes, place));
    const auto accessor_of = [&](std::size_t index) -> const tinygltf::Accessor& {
        return data.model.accessors[index];
    };
    if (const auto indices = primitive.find("indices"); indices != primitive.end() && counts.known) {
        const std::size_t declared = accessor_of(indices->get<std::size_t>()).count;
        if (counts.faces * 3 != declared)
            return file.error(
                place, fmt::format("{} triangles; expected the {} indices of the accessor", counts.faces, declared));
    }
    if (counts.known && counts.faces > bytes.size() * 256 + 65536)
        return file.error(place, fmt::format("{} triangles in {} bytes; expected fewer", counts.faces, bytes.size()));

    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok())
        return file.error(place, fmt::format("does not decode ({}); expected intact Draco data",
                                             decoded.status().error_msg_string()));
    draco::Mesh& mesh = *decoded.value();
    const std::size_t points = mesh.num_points();

    for (const auto& [name, id] : extension.at("attributes").items()) {
        // What the caller made room for: a skin's sets of joints and weights.
        const auto set_of = [&](std::string_view prefix, auto& sets) -> std::vector<float>* {
            for (std::size_t set = 0; set < sets.size(); ++set)
                if (name == fmt::format("{}{}", prefix, set)) return &sets[set];
            return nullptr;
        };
        std::vector<float>* const joints = set_of("JOINTS_", streams.joints);
        std::vector<float>* const weights = set_of("WEIGHTS_", streams.weights);
        std::vector<float>* const influence = joints ? joints : weights;
        const bool wanted =
            name == "POSITION" || name == "NORMAL" || name == "COLOR_0" || name == uv_name || influence != nullptr;
        if (!wanted) continue;
        const std::string attribute_place = fmt::format("{}.attributes.{}", place, name);
        const int attribute_id = mesh.GetAttributeIdByUniqueId(id.get<std::uint32_t>());
        if (attribute_id < 0)
            return file.error(attribute_place,
                              fmt::format("id {}; expected one of the Draco mesh", id.get<unsigned>()));
        bool normalized = false;
        std::size_t components = name == "COLOR_0" || influence ? 4 : name == uv_name ? 2 : 3;
        if (const auto accessor = primitive.at("attributes").find(name); accessor != primitive.at("attributes").end()) {
            const tinygltf::Accessor& declared = accessor_of(accessor->get<std::size_t>());
            normalized = declared.normalized;
            if (declared.count != points)
                return file.error(attribute_place,
                                  fmt::format("{} points; expected the accessor's {}", points, declared.count));
            if (name == "COLOR_0") components = components_of(declared);
        }
        if (components != 3 && components != 4 && name == "COLOR_0")
            return file.error(attribute_place, fmt::format("{} components; expected 3 or 4", components));
        std::vector<float> values = read_attribute(mesh, attribute_id, normalized, components);
        for (std::size_t i = 0; i < values.size(); ++i)
            if (!std::isfinite(values[i]))
                return file.error(fmt::format("{}: element {}", attribute_place, i / components),
                                  fmt::format("{}; expected a finite number", values[i]));
        if (influence) {
            *influence = std::move(values);
        } else if (name == "POSITION") {
            streams.positions = std::move(values);
        } else if (name == "NORMAL") {
            streams.normals = std::move(values);
        } else if (name == "COLOR_0") {
            streams.colors = std::move(values);
            streams.color_components = components;
        } else {
            streams.uvs = std::move(values);
        }
    }

    streams.has_indices = true;
    streams.indices.clear();
    streams.indices.reserve(std::size_t{mesh.num_faces()} * 3);
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
        for (const draco::PointIndex& point : mesh.face(f)) streams.indices.push_back(point.value());
    return {};
}

}  // namespace

Status decode_draco(const GltfData& data, const nlohmann::json& primitive, const std::string& uv_name,
                    const std::string& place, PrimitiveStreams& streams) {
    const std::string at = place + ".extensions.KHR_draco_mesh_compression";
    try {  // Draco throws where memory fails
        return decode(data, primitive, uv_name, at, streams);
    } catch (const std::exception& e) {
        return data.file.error(at, fmt::format("does not decode ({}); expected intact Draco data", e.what()));
    }
}

}  // namespace ff::cook
