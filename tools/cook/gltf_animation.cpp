#include "tools/cook/gltf_animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/cook/clip_tracks.h"

namespace ff::cook {
namespace {

using nlohmann::json;
using scene::Interpolation;
using scene::TrackPath;

std::optional<TrackPath> path_of(const std::string& name) {
    if (name == "translation") return TrackPath::translation;
    if (name == "rotation") return TrackPath::rotation;
    if (name == "scale") return TrackPath::scale;
    return std::nullopt;
}

Status check_times(const GltfData& data, const std::vector<float>& times, const std::string& place) {
    for (std::size_t k = 0; k < times.size(); ++k) {
        const bool ascends = times[k] >= 0.0f && (k == 0 || times[k] > times[k - 1]);
        if (!ascends || times[k] > 1e8f)
            return data.file.error(fmt::format("{}: element {}", place, k),
                                   fmt::format("{} s; expected ascending times from 0", times[k]));
    }
    return {};
}

/// Rotations to length 1; tangents stay.
Status normalize_rotations(const GltfData& data, SourceTrack& track, const std::string& place) {
    const std::size_t stride = track.interpolation == Interpolation::cubic ? 12 : 4;
    for (std::size_t k = 0; k < track.times.size(); ++k) {
        float* q = track.values.data() + k * stride + (stride == 12 ? 4 : 0);
        const double length =
            std::sqrt(double(q[0]) * q[0] + double(q[1]) * q[1] + double(q[2]) * q[2] + double(q[3]) * q[3]);
        if (!(length > 1e-6))
            return data.file.error(fmt::format("{}: element {}", place, k),
                                   "a rotation of length 0; expected a unit quaternion");
        for (int i = 0; i < 4; ++i) q[i] = static_cast<float>(q[i] / length);
    }
    return {};
}

Result<SourceTrack> read_track(const GltfData& data, const json& sampler, TrackPath path, std::uint32_t joint,
                               const std::string& place) {
    SourceTrack track{.joint = joint, .path = path};
    const std::string mode = sampler.value("interpolation", std::string("LINEAR"));
    track.interpolation = mode == "STEP"          ? Interpolation::step
                          : mode == "CUBICSPLINE" ? Interpolation::cubic
                                                  : Interpolation::linear;
    const std::size_t components = scene::components_of(path);
    FF_ASSIGN(track.times, read_floats(data, sampler.at("input").get<int>(), 1, place + ".input"));
    FF_TRY(check_times(data, track.times, place + ".input"));
    FF_ASSIGN(track.values, read_floats(data, sampler.at("output").get<int>(), components, place + ".output"));
    const std::size_t expected = track.times.size() * (track.interpolation == Interpolation::cubic ? 3 : 1);
    if (track.values.size() != expected * components)
        return data.file.error(place + ".output",
                               fmt::format("{} values; expected {} for {} times", track.values.size() / components,
                                           expected, track.times.size()));
    if (path == TrackPath::rotation) FF_TRY(normalize_rotations(data, track, place + ".output"));
    for (std::size_t i = 0; i < track.values.size(); ++i)
        if (!(std::fabs(track.values[i]) <= 1e8f))
            return data.file.error(fmt::format("{}.output: element {}", place, i / components),
                                   fmt::format("{}; expected at most 1e8", track.values[i]));
    return track;
}

std::string own_name(std::string name, const std::vector<scene::Clip>& clips) {
    const auto is_taken = [&](const std::string& wanted) {
        return std::ranges::any_of(clips, [&](const scene::Clip& clip) { return clip.name == wanted; });
    };
    name = name.substr(0, 1000);
    std::string own = name;
    for (int n = 2; is_taken(own); ++n) own = fmt::format("{} {}", name, n);
    return own;
}

}  // namespace

Result<std::vector<scene::Clip>> read_clips(const GltfData& data, const std::vector<std::uint32_t>& joint_of_node,
                                            float size_m, CookContext& context) {
    std::vector<scene::Clip> clips;
    const auto animations = data.file.json.find("animations");
    if (animations == data.file.json.end()) return clips;
    for (std::size_t a = 0; a < animations->size(); ++a) {
        const json& animation = (*animations)[a];
        std::string name = animation.value("name", std::string());
        if (name.empty()) name = fmt::format("clip{}", a);
        std::vector<SourceTrack> tracks;
        for (const json& channel : animation.at("channels")) {
            const json& target = channel.at("target");
            const auto path = path_of(target.at("path").get<std::string>());
            if (target.at("path") == "weights")
                context.warn(
                    fmt::format("{}: animation \"{}\" moves morph targets; it plays without", data.file.name, name));
            if (!path || !target.contains("node")) continue;
            const std::uint32_t joint = joint_of_node[target.at("node").get<std::size_t>()];
            if (joint == scene::kNoJoint) continue;
            const auto sampler = channel.at("sampler").get<std::size_t>();
            FF_ASSIGN(SourceTrack track, read_track(data, animation.at("samplers")[sampler], *path, joint,
                                                    fmt::format("animations[{}].samplers[{}]", a, sampler)));
            tracks.push_back(std::move(track));
        }
        if (tracks.empty()) continue;
        std::ranges::sort(tracks, [](const SourceTrack& x, const SourceTrack& y) {
            return x.joint != y.joint ? x.joint < y.joint : x.path < y.path;
        });
        scene::Clip clip{.name = own_name(name, clips)};
        for (SourceTrack& track : tracks) add_track(std::move(track), kMaxTranslationError * size_m, clip);
        clips.push_back(std::move(clip));
    }
    return clips;
}

}  // namespace ff::cook
