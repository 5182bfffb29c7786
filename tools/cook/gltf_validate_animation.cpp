#include "tools/cook/gltf_validate_animation.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <set>

namespace ff::cook {
namespace {

using nlohmann::json;

constexpr std::size_t kMostJointsOfSkin = 1u << 16;  // joints of vertices are 16 bits

class AnimationValidator {
  public:
    explicit AnimationValidator(const GltfFile& file) : file_(file) {}

    Status run() const {
        const json& nodes = collection("nodes");
        for (std::size_t i = 0; i < nodes.size(); ++i)
            FF_TRY(check_optional(nodes[i], "skin", fmt::format("nodes[{}]", i), collection("skins").size()));
        const json& skins = collection("skins");
        for (std::size_t i = 0; i < skins.size(); ++i) FF_TRY(check_skin(skins[i], fmt::format("skins[{}]", i)));
        const json& animations = collection("animations");
        for (std::size_t i = 0; i < animations.size(); ++i)
            FF_TRY(check_animation(animations[i], fmt::format("animations[{}]", i)));
        return {};
    }

  private:
    const json& collection(const char* name) const {
        static const json empty = json::array();
        const auto found = file_.json.find(name);
        return found == file_.json.end() ? empty : *found;
    }
    static std::string described(const json& value) {
        std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
        return text.size() <= 40 ? text : text.substr(0, 37) + "...";
    }
    Status check_index(const json& value, const std::string& place, std::size_t count) const {
        if (value.is_number_unsigned() && value.get<std::uint64_t>() < count) return {};
        return file_.error(place, fmt::format("{}; expected an index below {}", described(value), count));
    }
    Status check_optional(const json& object, const char* key, const std::string& place, std::size_t count) const {
        const auto found = object.find(key);
        return found == object.end() ? Status() : check_index(*found, fmt::format("{}.{}", place, key), count);
    }
    Status check_required(const json& object, const char* key, const std::string& place, std::size_t count) const {
        if (!object.contains(key)) return file_.error(place, fmt::format("no `{}`; expected one", key));
        return check_optional(object, key, place, count);
    }
    /// An array of objects at `key`, which must be there.
    Status check_objects(const json& object, const char* key, const std::string& place) const {
        const auto found = object.find(key);
        const std::string at = fmt::format("{}.{}", place, key);
        if (found == object.end() || !found->is_array())
            return file_.error(at, found == object.end() ? "none; expected an array"
                                                         : fmt::format("{}; expected an array", described(*found)));
        for (std::size_t i = 0; i < found->size(); ++i)
            if (!(*found)[i].is_object())
                return file_.error(fmt::format("{}[{}]", at, i),
                                   fmt::format("{}; expected an object", described((*found)[i])));
        return {};
    }

    Status check_skin(const json& skin, const std::string& place) const {
        const auto joints = skin.find("joints");
        if (joints == skin.end() || !joints->is_array() || joints->empty() || joints->size() > kMostJointsOfSkin)
            return file_.error(place + ".joints",
                               fmt::format("{}; expected an array of 1 to {} nodes",
                                           joints == skin.end() ? "none" : described(*joints), kMostJointsOfSkin));
        for (std::size_t j = 0; j < joints->size(); ++j)
            FF_TRY(check_index((*joints)[j], fmt::format("{}.joints[{}]", place, j), collection("nodes").size()));
        FF_TRY(check_optional(skin, "skeleton", place, collection("nodes").size()));
        return check_optional(skin, "inverseBindMatrices", place, collection("accessors").size());
    }

    Status check_animation(const json& animation, const std::string& place) const {
        if (const auto name = animation.find("name"); name != animation.end() && !name->is_string())
            return file_.error(place + ".name", fmt::format("{}; expected a string", described(*name)));
        FF_TRY(check_objects(animation, "samplers", place));
        FF_TRY(check_objects(animation, "channels", place));
        const json& samplers = animation.at("samplers");
        for (std::size_t s = 0; s < samplers.size(); ++s) {
            const std::string at = fmt::format("{}.samplers[{}]", place, s);
            FF_TRY(check_required(samplers[s], "input", at, collection("accessors").size()));
            FF_TRY(check_required(samplers[s], "output", at, collection("accessors").size()));
            const auto mode = samplers[s].find("interpolation");
            if (mode != samplers[s].end() && *mode != "STEP" && *mode != "LINEAR" && *mode != "CUBICSPLINE")
                return file_.error(at + ".interpolation",
                                   fmt::format("{}; expected STEP, LINEAR or CUBICSPLINE", described(*mode)));
        }
        std::set<std::pair<std::uint64_t, std::string>> targets;
        const json& channels = animation.at("channels");
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const std::string at = fmt::format("{}.channels[{}]", place, c);
            FF_TRY(check_required(channels[c], "sampler", at, samplers.size()));
            const auto target = channels[c].find("target");
            if (target == channels[c].end() || !target->is_object())
                return file_.error(at + ".target", "none; expected an object");
            FF_TRY(check_optional(*target, "node", at + ".target", collection("nodes").size()));
            const auto path = target->find("path");
            if (path == target->end() || !path->is_string())
                return file_.error(at + ".target.path", "none; expected a string");
            if (target->contains("node") &&
                !targets.emplace(target->at("node").get<std::uint64_t>(), path->get<std::string>()).second)
                return file_.error(at + ".target",
                                   fmt::format("{} a second time; expected each once", described(*target)));
        }
        return {};
    }

    const GltfFile& file_;
};

}  // namespace

Status validate_animation(const GltfFile& file) {
    return AnimationValidator(file).run();
}

}  // namespace ff::cook
