#include "tools/cook/gltf_validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "tools/cook/gltf_validate_animation.h"

namespace ff::cook {
namespace {

using nlohmann::json;

constexpr std::string_view kReadExtensions[] = {
    "KHR_draco_mesh_compression",      "KHR_mesh_quantization",
    "KHR_texture_transform",           "KHR_materials_unlit",
    "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
    "EXT_mesh_gpu_instancing",         "EXT_texture_webp",
    "EXT_meshopt_compression",
};

constexpr std::uint64_t kNoIndex = ~0ull;
// Counts beyond this cannot be addressed by 32-bit indices.
constexpr std::uint64_t kMaxCount = 0xFFFFFFFFull;

/// Walks the document; each check returns the first break that it meets.
class Validator {
  public:
    Validator(const GltfFile& file, CookContext& context) : file_(file), root_(file.json), context_(context) {}

    Status run() {
        FF_TRY(check_asset());
        FF_TRY(check_extensions());
        FF_TRY(check_collections());
        FF_TRY(check_buffers());
        FF_TRY(check_views());
        FF_TRY(check_accessors());
        FF_TRY(check_images_and_textures());
        FF_TRY(check_materials());
        FF_TRY(check_meshes());
        FF_TRY(check_nodes());
        return check_scenes();
    }

  private:
    Error error(const std::string& place, const std::string& text) const { return file_.error(place, text); }

    std::uint64_t size_of(const char* collection) const {
        const auto found = root_.find(collection);
        return found == root_.end() ? 0 : found->size();
    }
    const json& collection(const char* name) const {
        static const json empty = json::array();
        const auto found = root_.find(name);
        return found == root_.end() ? empty : *found;
    }
    static std::string described(const json& value) {
        std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
        return text.size() <= 40 ? text : text.substr(0, 37) + "...";
    }

    // A whole number of [low, high], or `fallback` where the key is absent.
    Result<std::uint64_t> unsigned_of(const json& object, const char* key, const std::string& place,
                                      std::optional<std::uint64_t> fallback, std::uint64_t low = 0,
                                      std::uint64_t high = 1ull << 53) const {
        const auto found = object.find(key);
        if (found == object.end()) {
            if (fallback) return *fallback;
            return error(place, fmt::format("no `{}`; expected one", key));
        }
        if (!found->is_number_unsigned() || found->get<std::uint64_t>() < low || found->get<std::uint64_t>() > high)
            return error(fmt::format("{}.{}", place, key),
                         fmt::format("{}; expected a whole number of [{}, {}]", described(*found), low, high));
        return found->get<std::uint64_t>();
    }

    Status check_index(const json& value, const std::string& place, std::uint64_t count) const {
        if (value.is_number_unsigned() && value.get<std::uint64_t>() < count) return {};
        return error(place, fmt::format("{}; expected an index below {}", described(value), count));
    }
    Status check_optional_index(const json& object, const char* key, const std::string& place, const char* into) const {
        const auto found = object.find(key);
        if (found == object.end()) return {};
        return check_index(*found, fmt::format("{}.{}", place, key), size_of(into));
    }
    // `count` finite numbers that stay finite in single precision.
    Status check_numbers(const json& object, const char* key, const std::string& place, std::size_t count) const {
        const auto found = object.find(key);
        if (found == object.end()) return {};
        const bool good = found->is_array() && found->size() == count &&
                          std::all_of(found->begin(), found->end(), [](const json& number) {
                              return number.is_number() && std::abs(number.get<double>()) < 1e30;
                          });
        if (good) return {};
        return error(fmt::format("{}.{}", place, key),
                     fmt::format("{}; expected {} finite numbers", described(*found), count));
    }

    Status check_asset() const {
        const auto asset = root_.find("asset");
        if (asset == root_.end() || !asset->is_object() || !asset->contains("version"))
            return error("asset", "no version; expected asset.version \"2.0\"");
        const json& version = asset->at("version");
        if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2."))
            return error("asset.version", fmt::format("{}; expected \"2.0\"", described(version)));
        return {};
    }

    Status check_extensions() const {
        const auto known = [](const std::string& name) {
            return std::find(std::begin(kReadExtensions), std::end(kReadExtensions), name) != std::end(kReadExtensions);
        };
        for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
            const json& names = collection(key);
            if (!names.is_array()) return error(key, fmt::format("{}; expected an array", described(names)));
            for (std::size_t i = 0; i < names.size(); ++i) {
                const std::string place = fmt::format("{}[{}]", key, i);
                if (!names[i].is_string())
                    return error(place, fmt::format("{}; expected a string", described(names[i])));
                const auto& name = names[i].get_ref<const std::string&>();
                if (known(name)) continue;
                if (std::string_view(key) == "extensionsRequired")
                    return error(place, fmt::format("the model requires {}; expected only extensions that are read: {}",
                                                    name, fmt::join(kReadExtensions, ", ")));
                context_.warn(fmt::format("glTF extension {} is not read; models that use it are drawn without", name));
            }
        }
        return {};
    }

    // Every collection is an array of objects.
    Status check_collections() const {
        for (const char* key : {"buffers", "bufferViews", "accessors", "images", "samplers", "textures", "materials",
                                "meshes", "nodes", "scenes", "skins", "animations", "cameras"}) {
            const json& array = collection(key);
            if (!array.is_array()) return error(key, fmt::format("{}; expected an array", described(array)));
            for (std::size_t i = 0; i < array.size(); ++i) {
                const std::string place = fmt::format("{}[{}]", key, i);
                if (!array[i].is_object())
                    return error(place, fmt::format("{}; expected an object", described(array[i])));
                const auto extensions = array[i].find("extensions");
                if (extensions != array[i].end() && !extensions->is_object())
                    return error(place + ".extensions", fmt::format("{}; expected an object", described(*extensions)));
            }
        }
        return {};
    }

    Status check_buffers() {
        const json& buffers = collection("buffers");
        for (std::size_t i = 0; i < buffers.size(); ++i) {
            const std::string place = fmt::format("buffers[{}]", i);
            FF_ASSIGN(const std::uint64_t length, unsigned_of(buffers[i], "byteLength", place, std::nullopt, 1));
            if (const auto uri = buffers[i].find("uri"); uri != buffers[i].end() && !uri->is_string())
                return error(place + ".uri", fmt::format("{}; expected a string", described(*uri)));
            buffer_lengths_.push_back(length);
        }
        return {};
    }

    // A range of a buffer, as views and their meshopt extension name it.
    Status check_buffer_range(const json& object, const std::string& place, std::uint64_t& length) const {
        FF_TRY(unsigned_of(object, "buffer", place, std::nullopt));
        FF_TRY(check_index(object.at("buffer"), place + ".buffer", buffer_lengths_.size()));
        FF_ASSIGN(const std::uint64_t offset, unsigned_of(object, "byteOffset", place, 0));
        FF_ASSIGN(length, unsigned_of(object, "byteLength", place, std::nullopt, 1));
        const std::uint64_t size = buffer_lengths_[object.at("buffer").get<std::size_t>()];
        if (offset > size || length > size - offset)
            return error(place, fmt::format("bytes [{}, {} + {}); expected inside its buffer of {}", offset, offset,
                                            length, size));
        return {};
    }

    Status check_views() {
        const json& views = collection("bufferViews");
        for (std::size_t i = 0; i < views.size(); ++i) {
            const std::string place = fmt::format("bufferViews[{}]", i);
            View view;
            const json::json_pointer meshopt("/extensions/EXT_meshopt_compression");
            FF_ASSIGN(view.stride, unsigned_of(views[i], "byteStride", place, 0, 4, 252));
            if (view.stride % 4 != 0)
                return error(place + ".byteStride", fmt::format("{}; expected a multiple of 4", view.stride));
            FF_TRY(check_buffer_range(views[i], place, view.length));
            if (view.stride > view.length)
                return error(place + ".byteStride",
                             fmt::format("{}; expected at most the view's {} bytes", view.stride, view.length));
            if (views[i].contains(meshopt)) FF_TRY(check_meshopt(views[i].at(meshopt), place, view.length));
            views_.push_back(view);
        }
        return {};
    }

    Status check_meshopt(const json& extension, const std::string& view_place, std::uint64_t view_length) const {
        const std::string place = view_place + ".extensions.EXT_meshopt_compression";
        if (!extension.is_object()) return error(place, "not an object; expected one");
        std::uint64_t packed = 0;
        FF_TRY(check_buffer_range(extension, place, packed));
        FF_ASSIGN(const std::uint64_t stride, unsigned_of(extension, "byteStride", place, std::nullopt, 1, 256));
        FF_ASSIGN(const std::uint64_t count, unsigned_of(extension, "count", place, std::nullopt, 0, kMaxCount));
        if (count * stride != view_length)
            return error(place, fmt::format("{} elements of {} bytes; expected the view's {} bytes", count, stride,
                                            view_length));
        // The codecs cannot make more of a byte than this: a bound before memory is given out.
        if (count * stride > packed * 80 + 4096)
            return error(place + ".count", fmt::format("{}; expected no more than {} bytes can hold", count, packed));
        for (const char* key : {"mode", "filter"}) {
            const auto found = extension.find(key);
            if (found != extension.end() && !found->is_string())
                return error(fmt::format("{}.{}", place, key), "not a string; expected one");
        }
        return {};
    }

    Status check_in_view(const std::string& place, std::uint64_t view, std::uint64_t offset, std::uint64_t count,
                         std::uint64_t element, std::uint64_t stride) const {
        if (view >= views_.size())
            return error(place + ".bufferView", fmt::format("{}; expected an index below {}", view, views_.size()));
        const std::uint64_t length = views_[view].length;
        if (stride < element)
            return error(place, fmt::format("elements of {} bytes every {}; expected a byteStride of at least {}",
                                            element, stride, element));
        if (count == 0) return {};
        if (count > kMaxCount || offset > length || (count - 1) * stride + element > length - offset)
            return error(place, fmt::format("{} elements of {} bytes every {} from byte {}; expected inside view {} of "
                                            "{} bytes",
                                            count, element, stride, offset, view, length));
        return {};
    }

    Status check_accessors() {
        const json& accessors = collection("accessors");
        for (std::size_t i = 0; i < accessors.size(); ++i) {
            const json& accessor = accessors[i];
            const std::string place = fmt::format("accessors[{}]", i);
            FF_ASSIGN(const std::uint64_t type, unsigned_of(accessor, "componentType", place, std::nullopt));
            const std::size_t component = component_size(type > 10000 ? 0 : static_cast<int>(type));
            if (component == 0)
                return error(place + ".componentType", fmt::format("{}; expected 5120..5123, 5125 or 5126", type));
            FF_ASSIGN(const std::uint64_t count, unsigned_of(accessor, "count", place, std::nullopt, 1, kMaxCount));
            const auto name = accessor.find("type");
            const std::size_t components =
                name != accessor.end() && name->is_string() ? component_count(name->get<std::string>()) : 0;
            if (components == 0)
                return error(place + ".type", "none or unknown; expected SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
            const std::uint64_t element = component * components;
            FF_ASSIGN(const std::uint64_t view, unsigned_of(accessor, "bufferView", place, kNoIndex));
            FF_ASSIGN(const std::uint64_t offset, unsigned_of(accessor, "byteOffset", place, 0));
            if (view != kNoIndex) {
                const std::uint64_t stride =
                    view < views_.size() && views_[view].stride ? views_[view].stride : element;
                FF_TRY(check_in_view(place, view, offset, count, element, stride));
            }
            if (accessor.contains("sparse")) FF_TRY(check_sparse(accessor.at("sparse"), place, count, element));
        }
        return {};
    }

    Status check_sparse(const json& sparse, const std::string& accessor_place, std::uint64_t accessor_count,
                        std::uint64_t element) const {
        const std::string place = accessor_place + ".sparse";
        if (!sparse.is_object() || !sparse.contains("indices") || !sparse.contains("values") ||
            !sparse.at("indices").is_object() || !sparse.at("values").is_object())
            return error(place, "without indices and values; expected both as objects");
        FF_ASSIGN(const std::uint64_t count, unsigned_of(sparse, "count", place, std::nullopt, 1, accessor_count));
        const json& indices = sparse.at("indices");
        FF_ASSIGN(const std::uint64_t type,
                  unsigned_of(indices, "componentType", place + ".indices", std::nullopt, 5121, 5125));
        if (type != 5121 && type != 5123 && type != 5125)
            return error(place + ".indices.componentType", fmt::format("{}; expected 5121, 5123 or 5125", type));
        const std::uint64_t size = component_size(static_cast<int>(type));
        for (const bool are_indices : {true, false}) {
            const std::string key = place + (are_indices ? ".indices" : ".values");
            const json& part = are_indices ? indices : sparse.at("values");
            FF_ASSIGN(const std::uint64_t view, unsigned_of(part, "bufferView", key, std::nullopt));
            FF_ASSIGN(const std::uint64_t offset, unsigned_of(part, "byteOffset", key, 0, 0, 0x7FFFFFFF));
            const std::uint64_t bytes = are_indices ? size : element;
            FF_TRY(check_in_view(key, view, offset, count, bytes, bytes));
        }
        return {};
    }

    Status check_images_and_textures() const {
        const json& images = collection("images");
        for (std::size_t i = 0; i < images.size(); ++i) {
            const std::string place = fmt::format("images[{}]", i);
            const auto uri = images[i].find("uri");
            if (uri != images[i].end() && !uri->is_string())
                return error(place + ".uri", fmt::format("{}; expected a string", described(*uri)));
            if (uri == images[i].end() && !images[i].contains("bufferView"))
                return error(place, "neither uri nor bufferView; expected one");
            FF_TRY(check_optional_index(images[i], "bufferView", place, "bufferViews"));
        }
        const json& textures = collection("textures");
        for (std::size_t i = 0; i < textures.size(); ++i) {
            const std::string place = fmt::format("textures[{}]", i);
            FF_TRY(check_optional_index(textures[i], "source", place, "images"));
            FF_TRY(check_optional_index(textures[i], "sampler", place, "samplers"));
            const json::json_pointer webp("/extensions/EXT_texture_webp");
            if (textures[i].contains(webp) && textures[i].at(webp).is_object())
                FF_TRY(check_optional_index(textures[i].at(webp), "source", place + ".extensions.EXT_texture_webp",
                                            "images"));
        }
        return {};
    }

    // A textureInfo at `key`: an object whose index names a texture.
    Status check_texture_info(const json& object, const char* key, const std::string& parent) const {
        const auto info = object.find(key);
        if (info == object.end()) return {};
        const std::string place = fmt::format("{}.{}", parent, key);
        if (!info->is_object() || !info->contains("index")) return error(place, "no index; expected a texture's");
        FF_TRY(check_optional_index(*info, "index", place, "textures"));
        FF_TRY(unsigned_of(*info, "texCoord", place, 0, 0, 31));
        const json::json_pointer transform("/extensions/KHR_texture_transform");
        if (!info->contains(transform)) return {};
        const std::string transform_place = place + ".extensions.KHR_texture_transform";
        if (!info->at(transform).is_object()) return error(transform_place, "not an object; expected one");
        FF_TRY(check_numbers(info->at(transform), "offset", transform_place, 2));
        FF_TRY(check_numbers(info->at(transform), "scale", transform_place, 2));
        FF_TRY(check_number(info->at(transform), "rotation", transform_place));
        FF_TRY(unsigned_of(info->at(transform), "texCoord", transform_place, 0, 0, 31));
        return {};
    }
    Status check_number(const json& object, const char* key, const std::string& place) const {
        const auto found = object.find(key);
        if (found == object.end() || (found->is_number() && std::abs(found->get<double>()) < 1e30)) return {};
        return error(fmt::format("{}.{}", place, key), fmt::format("{}; expected a number", described(*found)));
    }

    Status check_materials() const {
        const json& materials = collection("materials");
        for (std::size_t i = 0; i < materials.size(); ++i) {
            const json& material = materials[i];
            const std::string place = fmt::format("materials[{}]", i);
            FF_TRY(check_texture_info(material, "emissiveTexture", place));
            FF_TRY(check_numbers(material, "emissiveFactor", place, 3));
            FF_TRY(check_number(material, "alphaCutoff", place));
            const auto mode = material.find("alphaMode");
            if (mode != material.end() && *mode != "OPAQUE" && *mode != "MASK" && *mode != "BLEND")
                return error(place + ".alphaMode", fmt::format("{}; expected OPAQUE, MASK or BLEND", described(*mode)));
            if (const auto pbr = material.find("pbrMetallicRoughness"); pbr != material.end()) {
                const std::string pbr_place = place + ".pbrMetallicRoughness";
                if (!pbr->is_object()) return error(pbr_place, "not an object; expected one");
                FF_TRY(check_texture_info(*pbr, "baseColorTexture", pbr_place));
                FF_TRY(check_texture_info(*pbr, "metallicRoughnessTexture", pbr_place));
                FF_TRY(check_numbers(*pbr, "baseColorFactor", pbr_place, 4));
                FF_TRY(check_number(*pbr, "metallicFactor", pbr_place));
                FF_TRY(check_number(*pbr, "roughnessFactor", pbr_place));
            }
            const json::json_pointer glossiness("/extensions/KHR_materials_pbrSpecularGlossiness");
            if (material.contains(glossiness)) {
                const json& extension = material.at(glossiness);
                const std::string extension_place = place + ".extensions.KHR_materials_pbrSpecularGlossiness";
                if (!extension.is_object()) return error(extension_place, "not an object; expected one");
                FF_TRY(check_texture_info(extension, "diffuseTexture", extension_place));
                FF_TRY(check_numbers(extension, "diffuseFactor", extension_place, 4));
                FF_TRY(check_number(extension, "glossinessFactor", extension_place));
            }
        }
        return {};
    }

    Status check_meshes() const {
        const json& meshes = collection("meshes");
        for (std::size_t m = 0; m < meshes.size(); ++m) {
            const std::string mesh_place = fmt::format("meshes[{}]", m);
            const auto primitives = meshes[m].find("primitives");
            if (primitives == meshes[m].end() || !primitives->is_array() || primitives->empty())
                return error(mesh_place, "no primitives; expected an array of at least one");
            for (std::size_t p = 0; p < primitives->size(); ++p)
                FF_TRY(check_primitive((*primitives)[p], fmt::format("{}.primitives[{}]", mesh_place, p)));
        }
        return {};
    }

    Status check_primitive(const json& primitive, const std::string& place) const {
        if (!primitive.is_object()) return error(place, "not an object; expected one");
        const auto attributes = primitive.find("attributes");
        if (attributes == primitive.end() || !attributes->is_object())
            return error(place + ".attributes", "none; expected an object of accessors");
        for (const auto& [name, accessor] : attributes->items())
            FF_TRY(check_index(accessor, fmt::format("{}.attributes.{}", place, name), size_of("accessors")));
        FF_TRY(check_optional_index(primitive, "indices", place, "accessors"));
        FF_TRY(check_optional_index(primitive, "material", place, "materials"));
        FF_TRY(unsigned_of(primitive, "mode", place, 4, 0, 6));
        const json::json_pointer draco("/extensions/KHR_draco_mesh_compression");
        if (primitive.contains("extensions") && !primitive.at("extensions").is_object())
            return error(place + ".extensions", "not an object; expected one");
        if (!primitive.contains(draco)) return {};
        const json& extension = primitive.at(draco);
        const std::string draco_place = place + ".extensions.KHR_draco_mesh_compression";
        if (!extension.is_object() || !extension.contains("bufferView") || !extension.contains("attributes") ||
            !extension.at("attributes").is_object())
            return error(draco_place, "without bufferView and attributes; expected both");
        FF_TRY(check_optional_index(extension, "bufferView", draco_place, "bufferViews"));
        for (const auto& [name, id] : extension.at("attributes").items())
            if (!id.is_number_unsigned() || id.get<std::uint64_t>() > 0x7FFFFFFF)
                return error(fmt::format("{}.attributes.{}", draco_place, name),
                             fmt::format("{}; expected an attribute's id", described(id)));
        return {};
    }

    Status check_nodes() {
        const json& nodes = collection("nodes");
        parents_.assign(nodes.size(), kNoIndex);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const std::string place = fmt::format("nodes[{}]", i);
            FF_TRY(check_optional_index(nodes[i], "mesh", place, "meshes"));
            FF_TRY(check_numbers(nodes[i], "matrix", place, 16));
            FF_TRY(check_numbers(nodes[i], "translation", place, 3));
            FF_TRY(check_numbers(nodes[i], "rotation", place, 4));
            FF_TRY(check_numbers(nodes[i], "scale", place, 3));
            const json::json_pointer instancing("/extensions/EXT_mesh_gpu_instancing/attributes");
            if (nodes[i].contains(instancing)) {
                const std::string at = place + ".extensions.EXT_mesh_gpu_instancing.attributes";
                if (!nodes[i].at(instancing).is_object()) return error(at, "not an object; expected one");
                for (const auto& [name, accessor] : nodes[i].at(instancing).items())
                    FF_TRY(check_index(accessor, fmt::format("{}.{}", at, name), size_of("accessors")));
            }
            const auto children = nodes[i].find("children");
            if (children == nodes[i].end()) continue;
            if (!children->is_array()) return error(place + ".children", "not an array; expected one");
            for (std::size_t c = 0; c < children->size(); ++c) {
                const std::string child_place = fmt::format("{}.children[{}]", place, c);
                FF_TRY(check_index((*children)[c], child_place, nodes.size()));
                std::uint64_t& parent = parents_[(*children)[c].get<std::size_t>()];
                if (parent != kNoIndex)
                    return error(child_place, fmt::format("node {} which node {} has already; expected one parent",
                                                          (*children)[c].get<std::size_t>(), parent));
                parent = i;
            }
        }
        // With one parent each, a loop is a walk upwards that comes back. `seen` holds the walk's start: every node is
        // stepped on twice at most.
        std::vector<std::uint64_t> seen(nodes.size(), kNoIndex);
        for (std::size_t start = 0; start < nodes.size(); ++start)
            for (std::uint64_t node = start; node != kNoIndex; node = parents_[node]) {
                if (seen[node] == start)
                    return error(fmt::format("nodes[{}]", node), "an ancestor of itself; expected no loops");
                if (seen[node] != kNoIndex) break;
                seen[node] = start;
            }
        return {};
    }

    Status check_scenes() const {
        const json& scenes = collection("scenes");
        for (std::size_t s = 0; s < scenes.size(); ++s) {
            const auto roots = scenes[s].find("nodes");
            if (roots == scenes[s].end()) continue;
            const std::string place = fmt::format("scenes[{}].nodes", s);
            if (!roots->is_array()) return error(place, "not an array; expected one");
            std::vector<bool> listed(parents_.size(), false);
            for (std::size_t r = 0; r < roots->size(); ++r) {
                const std::string at = fmt::format("{}[{}]", place, r);
                FF_TRY(check_index((*roots)[r], at, parents_.size()));
                const auto node = (*roots)[r].get<std::size_t>();
                if (parents_[node] != kNoIndex)
                    return error(at, fmt::format("{}, a child of node {}; expected a root", node, parents_[node]));
                if (listed[node]) return error(at, fmt::format("{} a second time; expected each root once", node));
                listed[node] = true;
            }
        }
        if (const auto scene = root_.find("scene"); scene != root_.end())
            return check_index(*scene, "scene", scenes.size());
        return {};
    }

    struct View {
        std::uint64_t length = 0, stride = 0;  // stride 0: tightly packed
    };
    const GltfFile& file_;
    const json& root_;
    CookContext& context_;
    std::vector<std::uint64_t> buffer_lengths_;
    std::vector<View> views_;
    std::vector<std::uint64_t> parents_;
};

}  // namespace

Status validate_gltf(const GltfFile& file, CookContext& context) {
    FF_TRY(Validator(file, context).run());
    return validate_animation(file);
}

std::size_t component_size(int component_type) {
    switch (component_type) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            return 0;
    }
}

std::size_t component_count(const std::string& type) {
    constexpr std::pair<std::string_view, std::size_t> kTypes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                                   {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    for (const auto& [name, count] : kTypes)
        if (name == type) return count;
    return 0;
}

}  // namespace ff::cook
