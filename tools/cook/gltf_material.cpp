#include "tools/cook/gltf_material.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "tools/cook/image_load.h"

namespace ff::cook {
namespace {

using nlohmann::json;

// A rough dielectric shows no highlight worth its cost.
constexpr float kDullRoughness = 0.7f;
constexpr float kDullMetallic = 0.1f;

scene::Wrap wrap_of(int gl_wrap) {
    switch (gl_wrap) {
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
            return scene::Wrap::clamp;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
            return scene::Wrap::mirror;
        default:
            return scene::Wrap::repeat;
    }
}

float number_of(const json& object, const char* key, float fallback) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<float>() : fallback;
}

UvTransform transform_of(const json& info) {
    UvTransform transform;
    transform.set = static_cast<int>(number_of(info, "texCoord", 0.0f));
    const json::json_pointer at("/extensions/KHR_texture_transform");
    if (!info.contains(at)) return transform;
    const json& extension = info.at(at);
    if (extension.contains("texCoord")) transform.set = static_cast<int>(number_of(extension, "texCoord", 0.0f));
    const auto pair = [&](const char* key, float fallback) {
        const auto found = extension.find(key);
        return found == extension.end() ? Vec2(fallback) : Vec2((*found)[0].get<float>(), (*found)[1].get<float>());
    };
    const Vec2 offset = pair("offset", 0.0f), scale = pair("scale", 1.0f);
    const float angle = number_of(extension, "rotation", 0.0f);
    // The extension's own formula: translation * rotation * scale, rotation counter-clockwise with v downwards.
    const float c = std::cos(angle), s = std::sin(angle);
    transform.m[0][0] = c * scale.x, transform.m[0][1] = s * scale.y, transform.m[0][2] = offset.x;
    transform.m[1][0] = -s * scale.x, transform.m[1][1] = c * scale.y, transform.m[1][2] = offset.y;
    return transform;
}

/// Collects the textures that materials ask for; each image with each pair of wraps becomes one.
class TextureSet {
  public:
    TextureSet(GltfFile& file, const GltfData& data) : file_(file), data_(data) {}

    // Texture id for a textureInfo; kNoTexture where its texture has no image.
    std::uint32_t request(const json& info) {
        const auto index = info.at("index").get<std::size_t>();
        const tinygltf::Texture& texture = data_.model.textures[index];
        int image = texture.source;
        const json& source = file_.json.at("textures")[index];
        const json::json_pointer webp("/extensions/EXT_texture_webp/source");
        if (source.contains(webp)) image = source.at(webp).get<int>();
        if (image < 0) return scene::kNoTexture;
        Request request{.image = static_cast<std::size_t>(image)};
        if (texture.sampler >= 0) {
            const tinygltf::Sampler& sampler = data_.model.samplers[static_cast<std::size_t>(texture.sampler)];
            request.wrap_u = wrap_of(sampler.wrapS);
            request.wrap_v = wrap_of(sampler.wrapT);
        }
        const auto known = std::find(requests_.begin(), requests_.end(), request);
        if (known != requests_.end()) return static_cast<std::uint32_t>(known - requests_.begin());
        requests_.push_back(request);
        return static_cast<std::uint32_t>(requests_.size() - 1);
    }

    Result<std::vector<SourceTexture>> decode(CookContext& context) {
        // Bytes first, one by one (they may be files), then the dear part in parallel: each image once.
        std::vector<std::size_t> images;
        for (const Request& request : requests_)
            if (std::find(images.begin(), images.end(), request.image) == images.end()) images.push_back(request.image);
        std::vector<Bytes> bytes(images.size());
        for (std::size_t i = 0; i < images.size(); ++i) {
            FF_ASSIGN(bytes[i], image_bytes(images[i]));
        }
        std::vector<std::optional<Result<SourceTexture>>> decoded(images.size());
        Progress progress("decoding images", images.size());
        parallel_for(images.size(), [&](std::size_t i) {
            decoded[i] = decode_texture(bytes[i], fmt::format("{}: images[{}]", file_.name, images[i]), context);
            progress.advance();
        });
        for (const auto& image : decoded)
            if (!*image) return image->error();

        std::vector<SourceTexture> textures;
        for (const Request& request : requests_) {
            const auto at = std::find(images.begin(), images.end(), request.image) - images.begin();
            textures.push_back(**decoded[static_cast<std::size_t>(at)]);
            textures.back().wrap_u = request.wrap_u;
            textures.back().wrap_v = request.wrap_v;
        }
        return textures;
    }

  private:
    struct Request {
        std::size_t image = 0;
        scene::Wrap wrap_u = scene::Wrap::repeat, wrap_v = scene::Wrap::repeat;
        friend bool operator==(const Request&, const Request&) = default;
    };

    Result<Bytes> image_bytes(std::size_t index) {
        const json& image = file_.json.at("images")[index];
        if (const auto uri = image.find("uri"); uri != image.end())
            return load_uri(file_, uri->get_ref<const std::string&>(), fmt::format("images[{}].uri", index));
        return data_.views[image.at("bufferView").get<std::size_t>()];
    }

    GltfFile& file_;
    const GltfData& data_;
    std::vector<Request> requests_;
};

struct MaterialReader {
    const GltfFile& file;
    TextureSet& textures;
    CookContext& context;
    std::optional<UvTransform> uv;

    // One uv per vertex: the first texture asked for sets it, others must agree.
    std::uint32_t texture(const json& object, const char* key, const std::string& place) {
        const auto info = object.find(key);
        if (info == object.end()) return scene::kNoTexture;
        const std::uint32_t id = textures.request(*info);
        if (id == scene::kNoTexture) return id;
        const UvTransform transform = transform_of(*info);
        if (!uv) uv = transform;
        if (*uv == transform) return id;
        context.warn(fmt::format("{}: {}.{}: other texture coordinates than the base colour's; left out", file.name,
                                 place, key));
        return scene::kNoTexture;
    }

    scene::Material read(const json& source, const tinygltf::Material& typed, const std::string& place) {
        scene::Material material;
        uv.reset();
        const json empty = json::object();
        const json& extensions = source.contains("extensions") ? source.at("extensions") : empty;
        const auto glossiness = extensions.find("KHR_materials_pbrSpecularGlossiness");
        const bool has_metallic = source.contains("pbrMetallicRoughness");
        if (glossiness != extensions.end() && !has_metallic) {
            // Its diffuse part: what is left of the base colour of a dielectric.
            material.base_color = color_of(*glossiness, "diffuseFactor");
            material.base_color_texture = texture(*glossiness, "diffuseTexture", place);
            material.roughness = 1.0f - std::clamp(number_of(*glossiness, "glossinessFactor", 1.0f), 0.0f, 1.0f);
        } else {
            const json& pbr = has_metallic ? source.at("pbrMetallicRoughness") : empty;
            material.base_color = color_of(pbr, "baseColorFactor");
            material.base_color_texture = texture(pbr, "baseColorTexture", place);
            material.metallic = std::clamp(number_of(pbr, "metallicFactor", 1.0f), 0.0f, 1.0f);
            material.roughness = std::clamp(number_of(pbr, "roughnessFactor", 1.0f), 0.0f, 1.0f);
            material.metallic_roughness_texture = texture(pbr, "metallicRoughnessTexture", place);
        }

        float strength = 1.0f;
        if (const auto e = extensions.find("KHR_materials_emissive_strength"); e != extensions.end() && e->is_object())
            strength = std::clamp(number_of(*e, "emissiveStrength", 1.0f), 0.0f, 1e6f);
        for (int i = 0; i < 3; ++i)
            material.emissive[i] = static_cast<float>(typed.emissiveFactor[static_cast<std::size_t>(i)]) * strength;
        if (material.emissive != Vec3(0.0f)) material.emissive_texture = texture(source, "emissiveTexture", place);

        material.alpha_cutoff = static_cast<float>(typed.alphaCutoff);
        if (typed.alphaMode == "MASK") material.flags |= scene::kMaterialAlphaMask;
        if (typed.alphaMode == "BLEND") material.flags |= scene::kMaterialBlend;
        if (typed.doubleSided) material.flags |= scene::kMaterialDoubleSided;
        if (extensions.contains("KHR_materials_unlit"))
            material.flags |= scene::kMaterialUnlit;
        else if (material.roughness < kDullRoughness || material.metallic > kDullMetallic)
            material.flags |= scene::kMaterialSpecular;
        if (scene::is_smooth(material)) material.flags |= scene::kMaterialMirror;
        return material;
    }

    static Vec4 color_of(const json& object, const char* key) {
        const auto found = object.find(key);
        if (found == object.end()) return Vec4(1.0f);
        Vec4 color;
        for (int i = 0; i < 4; ++i)
            color[i] = std::clamp((*found)[static_cast<std::size_t>(i)].get<float>(), 0.0f, 1.0f);
        return color;
    }
};

}  // namespace

Result<ImportedMaterials> read_materials(GltfFile& file, const GltfData& data, CookContext& context) {
    const std::size_t count = data.model.materials.size();
    if (count > 0xFFFE) return file.error("materials", fmt::format("{} of them; expected at most 65534", count));
    ImportedMaterials imported;
    TextureSet textures(file, data);
    MaterialReader reader{.file = file, .textures = textures, .context = context, .uv = {}};
    for (std::size_t i = 0; i < count; ++i) {
        imported.materials.push_back(
            reader.read(file.json.at("materials")[i], data.model.materials[i], fmt::format("materials[{}]", i)));
        imported.has_texture.push_back(reader.uv.has_value());
        imported.uv_transforms.push_back(reader.uv.value_or(UvTransform{}));
    }
    // The default of primitives without a material; glTF's own is a rough metal, which nobody means: drawn as plaster.
    imported.materials.emplace_back();
    imported.uv_transforms.emplace_back();
    imported.has_texture.push_back(false);
    FF_ASSIGN(imported.textures, textures.decode(context));
    return imported;
}

}  // namespace ff::cook
