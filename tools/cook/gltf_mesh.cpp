#include "tools/cook/gltf_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cook/gltf_draco.h"

namespace ff::cook {
namespace {

using nlohmann::json;

Vec3 vec3_at(const std::vector<float>& values, std::size_t i) {
    return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

std::uint8_t unorm8(float value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f);
}

// Strips and fans as triangle lists, winding as glTF 2.0 section 3.7.2.1 defines it.
std::vector<std::uint32_t> triangle_list(const std::vector<std::uint32_t>& indices, int mode) {
    std::vector<std::uint32_t> list;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        list.assign(indices.begin(), indices.end() - static_cast<std::ptrdiff_t>(indices.size() % 3));
        return list;
    }
    for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
        if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
            list.insert(list.end(), {indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
        else
            list.insert(list.end(), {indices[i + 1], indices[i + 2], indices[0]});
    }
    return list;
}

// What of a primitive lies in plain accessors; whatever Draco holds is read there.
Result<PrimitiveStreams> read_streams(const GltfData& data, const tinygltf::Primitive& primitive, const json& source,
                                      const std::string& uv_name, bool with_joints, const std::string& place) {
    PrimitiveStreams streams;
    const json::json_pointer draco_at("/extensions/KHR_draco_mesh_compression/attributes");
    const json none = json::object();
    const json& compressed = source.contains(draco_at) ? source.at(draco_at) : none;
    const auto read = [&](const std::string& name, std::size_t components, std::vector<float>& out) -> Status {
        const auto attribute = primitive.attributes.find(name);
        if (attribute == primitive.attributes.end() || compressed.contains(name)) return {};
        FF_ASSIGN(out, read_floats(data, attribute->second, components, fmt::format("{}.attributes.{}", place, name)));
        return {};
    };
    FF_TRY(read("POSITION", 3, streams.positions));
    FF_TRY(read("NORMAL", 3, streams.normals));
    if (!uv_name.empty()) FF_TRY(read(uv_name, 2, streams.uvs));
    if (const auto color = primitive.attributes.find("COLOR_0"); color != primitive.attributes.end()) {
        streams.color_components = components_of(data.model.accessors[static_cast<std::size_t>(color->second)]);
        if (streams.color_components != 3 && streams.color_components != 4)
            return data.file.error(place + ".attributes.COLOR_0",
                                   fmt::format("{} components; expected 3 or 4", streams.color_components));
        FF_TRY(read("COLOR_0", streams.color_components, streams.colors));
    }
    if (with_joints) {
        std::size_t sets = 0;
        while (primitive.attributes.contains(fmt::format("JOINTS_{}", sets))) ++sets;
        streams.joints.resize(sets);
        streams.weights.resize(sets);
        for (std::size_t set = 0; set < sets; ++set) {
            const std::string joints = fmt::format("JOINTS_{}", set), weights = fmt::format("WEIGHTS_{}", set);
            if (!primitive.attributes.contains(weights))
                return data.file.error(fmt::format("{}.attributes", place),
                                       fmt::format("{} without {}; expected both", joints, weights));
            FF_TRY(read(joints, 4, streams.joints[set]));
            FF_TRY(read(weights, 4, streams.weights[set]));
        }
    }
    if (source.contains(draco_at)) {
        FF_TRY(decode_draco(data, source, uv_name, place, streams));
    } else if (primitive.indices >= 0) {
        FF_ASSIGN(streams.indices, read_indices(data, primitive.indices, place + ".indices"));
        streams.has_indices = true;
    }
    return streams;
}

Status check_lengths(const GltfData& data, const PrimitiveStreams& streams, const std::string& place) {
    const std::size_t vertices = streams.positions.size() / 3;
    const auto check = [&](const char* name, std::size_t values, std::size_t components) -> Status {
        if (values == 0 || values == vertices * components) return {};
        return data.file.error(fmt::format("{}.attributes.{}", place, name),
                               fmt::format("{} elements; expected the {} of POSITION", values / components, vertices));
    };
    FF_TRY(check("NORMAL", streams.normals.size(), 3));
    FF_TRY(check("TEXCOORD", streams.uvs.size(), 2));
    FF_TRY(check("COLOR_0", streams.colors.size(), streams.color_components));
    for (std::size_t set = 0; set < streams.joints.size(); ++set) {
        FF_TRY(check("JOINTS", streams.joints[set].size(), 4));
        FF_TRY(check("WEIGHTS", streams.weights[set].size(), 4));
    }
    for (std::size_t i = 0; i < streams.indices.size(); ++i)
        if (streams.indices[i] >= vertices)
            return data.file.error(fmt::format("{}.indices: element {}", place, i),
                                   fmt::format("{}; expected below the {} vertices", streams.indices[i], vertices));
    return {};
}

scene::VertexAttributes attributes_at(const PrimitiveStreams& streams, std::size_t i, const Vec3& normal,
                                      const UvTransform& uv) {
    scene::VertexAttributes out{};
    const float length = glm::length(normal);
    scene::encode_normal(length > 0.0f ? normal / length : Vec3(0, 1, 0), out.normal_oct);
    if (!streams.uvs.empty()) out.uv = uv.apply(streams.uvs[2 * i], streams.uvs[2 * i + 1]);
    out.color = 0xFFFFFFFFu;
    if (!streams.colors.empty()) {
        const float* c = streams.colors.data() + i * streams.color_components;
        const std::uint32_t alpha = streams.color_components == 4 ? unorm8(c[3]) : 255u;
        out.color = std::uint32_t{unorm8(c[0])} | std::uint32_t{unorm8(c[1])} << 8 | std::uint32_t{unorm8(c[2])} << 16 |
                    alpha << 24;
    }
    return out;
}

// The joints that a vertex follows, heaviest first.
Status append_influences(const GltfData& data, const PrimitiveStreams& streams, std::size_t vertex,
                         const std::string& place, SkinStreams& skin) {
    struct Influence {
        std::uint16_t joint;
        float weight;
    };
    std::vector<Influence> all;
    for (std::size_t set = 0; set < streams.joints.size(); ++set)
        for (std::size_t i = 4 * vertex; i < 4 * vertex + 4; ++i) {
            if (i >= streams.joints[set].size() || i >= streams.weights[set].size()) continue;  // all in Draco's
            const float joint = streams.joints[set][i], weight = streams.weights[set][i];
            if (!(weight >= 0.0f))
                return data.file.error(fmt::format("{}.attributes.WEIGHTS_{}: element {}", place, set, vertex),
                                       fmt::format("{}; expected [0, 1]", weight));
            if (!(weight > 0.0f)) continue;
            if (!(joint >= 0.0f && joint < static_cast<float>(skin.joint_count)))
                return data.file.error(fmt::format("{}.attributes.JOINTS_{}: element {}", place, set, vertex),
                                       fmt::format("{}; expected below the skin's {} joints", joint, skin.joint_count));
            all.push_back({static_cast<std::uint16_t>(joint), weight});
        }
    std::stable_sort(all.begin(), all.end(),
                     [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
    if (all.empty()) all.push_back({0, 1.0f});
    all.resize(scene::kMostInfluences, {all[0].joint, 0.0f});
    float sum = 0.0f;
    for (const Influence& influence : all) sum += influence.weight;
    for (const Influence& influence : all) {
        skin.joints.push_back(influence.joint);
        skin.weights.push_back(influence.weight / sum);
    }
    return {};
}

// Appends a primitive. Without normals every triangle gets its own, and so its own vertices.
// @return for each vertex that was appended the one of the streams
std::vector<std::size_t> append_primitive(const PrimitiveStreams& streams, const std::vector<std::uint32_t>& triangles,
                                          std::uint16_t material, const UvTransform& uv, scene::MeshSource& mesh) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    std::vector<std::size_t> sources;
    const auto add_vertex = [&](std::size_t i, const Vec3& normal) {
        sources.push_back(i);
        mesh.positions.push_back(vec3_at(streams.positions, i));
        mesh.attributes.push_back(attributes_at(streams, i, normal, uv));
    };
    if (!streams.normals.empty()) {
        for (std::size_t i = 0; i < streams.positions.size() / 3; ++i) add_vertex(i, vec3_at(streams.normals, i));
        for (const std::uint32_t index : triangles) mesh.indices.push_back(first + index);
    } else {
        for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
            const Vec3 a = vec3_at(streams.positions, triangles[t]);
            // In double: a float cross product of a far or sliver triangle may vanish or overflow.
            const DVec3 normal = glm::cross(DVec3(vec3_at(streams.positions, triangles[t + 1])) - DVec3(a),
                                            DVec3(vec3_at(streams.positions, triangles[t + 2])) - DVec3(a));
            const double length = glm::length(normal);
            const Vec3 unit = length > 0.0 ? Vec3(normal / length) : Vec3(0, 1, 0);
            for (std::size_t corner = 0; corner < 3; ++corner) {
                mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
                add_vertex(triangles[t + corner], unit);
            }
        }
    }
    mesh.triangle_materials.insert(mesh.triangle_materials.end(), triangles.size() / 3, material);
    return sources;
}

}  // namespace

Result<scene::MeshSource> read_mesh(const GltfData& data, std::size_t mesh_index, const ImportedMaterials& materials,
                                    CookContext& context, SkinStreams* skin) {
    scene::MeshSource mesh;
    const auto& primitives = data.model.meshes[mesh_index].primitives;
    for (std::size_t p = 0; p < primitives.size(); ++p) {
        const tinygltf::Primitive& primitive = primitives[p];
        const std::string place = fmt::format("meshes[{}].primitives[{}]", mesh_index, p);
        if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
            context.warn(fmt::format("{}: has points or lines; they are left out", data.file.name));
            continue;
        }
        if (!primitive.targets.empty())
            context.warn(fmt::format("{}: mesh \"{}\" has morph targets; it is drawn unmorphed", data.file.name,
                                     data.model.meshes[mesh_index].name));
        if (!primitive.attributes.contains("POSITION")) {
            context.warn(fmt::format("{}: {}: no POSITION; left out", data.file.name, place));
            continue;
        }
        const std::size_t material =
            primitive.material >= 0 ? static_cast<std::size_t>(primitive.material) : materials.materials.size() - 1;
        const UvTransform& uv = materials.uv_transforms[material];
        const std::string uv_name = materials.has_texture[material] ? fmt::format("TEXCOORD_{}", uv.set) : "";
        const json& source = data.file.json.at("meshes")[mesh_index].at("primitives")[p];
        FF_ASSIGN(PrimitiveStreams streams, read_streams(data, primitive, source, uv_name, skin != nullptr, place));
        FF_TRY(check_lengths(data, streams, place));
        if (!streams.has_indices) {
            streams.indices.resize(streams.positions.size() / 3);
            for (std::size_t i = 0; i < streams.indices.size(); ++i) streams.indices[i] = static_cast<std::uint32_t>(i);
        }
        const bool is_list = source.contains(json::json_pointer("/extensions/KHR_draco_mesh_compression"));
        const auto triangles = triangle_list(streams.indices, is_list ? TINYGLTF_MODE_TRIANGLES : primitive.mode);
        if (mesh.positions.size() + std::max(triangles.size(), streams.positions.size() / 3) > 0xFFFFFFF0ull)
            return data.file.error(place, "more vertices than 32 bits can count; expected fewer");
        const std::vector<std::size_t> sources =
            append_primitive(streams, triangles, static_cast<std::uint16_t>(material), uv, mesh);
        if (skin == nullptr) continue;
        for (const std::size_t vertex : sources) FF_TRY(append_influences(data, streams, vertex, place, *skin));
    }
    return mesh;
}

}  // namespace ff::cook
