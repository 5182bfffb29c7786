// The one translation unit that compiles tinygltf (some 20 s). TINYGLTF_NO_STB_IMAGE and TINYGLTF_NO_STB_IMAGE_WRITE
// change its classes and are therefore public definitions of the target. It includes nlohmann-json with hidden
// visibility, so that has to come first.
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include <fmt/format.h>

#include "tools/cook/gltf_parse.h"

namespace ff::cook {
namespace {

using nlohmann::json;

// What tinygltf shall not see. It would copy buffers and decode images one by one, and without its own Draco it refuses
// a compressed primitive whose index accessor has no view, which is how such files are written.
json without_data(const json& document) {
    json slim = json::object();
    for (const auto& [key, value] : document.items())
        if (key != "buffers" && key != "images" && key != "animations" && key != "skins" && key != "cameras" &&
            key != "extras" && key != "extensions")
            slim[key] = value;
    if (const auto meshes = slim.find("meshes"); meshes != slim.end())
        for (json& mesh : *meshes)
            for (json& primitive : mesh.at("primitives"))
                if (primitive.contains(json::json_pointer("/extensions/KHR_draco_mesh_compression")))
                    primitive.erase("indices");
    return slim;
}

}  // namespace

Result<tinygltf::Model> parse_gltf(const GltfFile& file) {
    tinygltf::Model model;
    std::string problem, warning;
    bool parsed = false;
    try {
        const std::string text = without_data(file.json).dump(-1, ' ', false, json::error_handler_t::replace);
        tinygltf::TinyGLTF loader;
        parsed = loader.LoadASCIIFromString(&model, &problem, &warning, text.data(),
                                            static_cast<unsigned int>(text.size()), "");
    } catch (const std::exception& e) {
        problem = e.what();
    }
    while (!problem.empty() && problem.back() == '\n') problem.pop_back();
    if (!parsed) return file.error("document", fmt::format("{}; expected glTF 2.0", problem));

    // A member that it cannot read, tinygltf drops: then everything after it would have the wrong index.
    const auto size_of = [&](const char* key) {
        const auto found = file.json.find(key);
        return found == file.json.end() ? std::size_t{0} : found->size();
    };
    bool complete = model.meshes.size() == size_of("meshes") && model.nodes.size() == size_of("nodes") &&
                    model.materials.size() == size_of("materials") && model.accessors.size() == size_of("accessors") &&
                    model.textures.size() == size_of("textures") && model.samplers.size() == size_of("samplers") &&
                    model.scenes.size() == size_of("scenes");
    for (std::size_t i = 0; complete && i < model.meshes.size(); ++i)
        complete = model.meshes[i].primitives.size() == file.json.at("meshes")[i].at("primitives").size();
    if (!complete) return file.error("document", fmt::format("{}; expected glTF 2.0", problem));
    return model;
}

}  // namespace ff::cook
