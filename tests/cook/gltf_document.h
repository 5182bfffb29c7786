#pragma once
// glTF documents in a few lines, good and bad ones.

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ff::test {

using nlohmann::json;

/// A document with one binary buffer. Everything in `document` may be changed before it is written.
struct GltfBuilder {
    json document = {{"asset", {{"version", "2.0"}}}};
    std::string binary;

    template <class T>
    int add_view(const std::vector<T>& values, int stride = 0) {
        while (binary.size() % 4 != 0) binary += '\0';
        json view = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", values.size() * sizeof(T)}};
        if (stride != 0) view["byteStride"] = stride;
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        document["bufferViews"].push_back(view);
        return static_cast<int>(document["bufferViews"].size()) - 1;
    }
    int add_accessor(int view, int component_type, const std::string& type, std::size_t count,
                     bool normalized = false) {
        json accessor = {{"componentType", component_type}, {"type", type}, {"count", count}};
        if (view >= 0) accessor["bufferView"] = view;
        if (normalized) accessor["normalized"] = true;
        document["accessors"].push_back(accessor);
        return static_cast<int>(document["accessors"].size()) - 1;
    }
    int add_positions(const std::vector<float>& xyz) {
        return add_accessor(add_view(xyz), 5126, "VEC3", xyz.size() / 3);
    }
    int add_mesh(const json& primitive) {
        document["meshes"].push_back({{"primitives", json::array({primitive})}});
        return static_cast<int>(document["meshes"].size()) - 1;
    }
    /// A node that is a root of scene 0.
    int add_node(const json& node) {
        document["nodes"].push_back(node);
        const int index = static_cast<int>(document["nodes"].size()) - 1;
        document["scenes"][0]["nodes"].push_back(index);
        return index;
    }
    /// One right triangle of legs 1 in the plane z = 0, drawn once: mesh 0, node 0, accessors 0 (positions), 1
    /// (indices).
    static GltfBuilder triangle() {
        GltfBuilder builder;
        const int positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
        const int indices = builder.add_accessor(builder.add_view<std::uint16_t>({0, 1, 2}), 5123, "SCALAR", 3);
        builder.add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
        builder.add_node({{"mesh", 0}});
        return builder;
    }

    [[nodiscard]] std::string glb() {
        if (!binary.empty()) document["buffers"] = json::array({{{"byteLength", binary.size()}}});
        std::string text = document.dump();
        while (text.size() % 4 != 0) text += ' ';
        std::string padded = binary;
        while (padded.size() % 4 != 0) padded += '\0';
        const auto u32 = [](std::uint64_t v) {
            const auto value = static_cast<std::uint32_t>(v);
            return std::string(reinterpret_cast<const char*>(&value), 4);
        };
        std::string out = "glTF" + u32(2) + u32(12 + 8 + text.size() + (padded.empty() ? 0 : 8 + padded.size()));
        out += u32(text.size()) + "JSON" + text;
        if (!padded.empty()) out += u32(padded.size()) + std::string("BIN\0", 4) + padded;
        return out;
    }
};

}  // namespace ff::test
