#include "engine/scene/check_animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <set>

namespace ff::scene {
namespace {

constexpr float kMaxNumber = 1e8f;  // metres and scales; durations in seconds
constexpr std::size_t kMaxNameBytes = 1024;

bool are_within(const float* values, std::size_t count, float limit = kMaxNumber) {
    return std::all_of(values, values + count, [=](float v) { return std::fabs(v) <= limit; });  // false for a NaN
}
template <class T>
bool are_within(const std::vector<T>& values, float limit = kMaxNumber) {
    return are_within(reinterpret_cast<const float*>(values.data()), values.size() * sizeof(T) / 4, limit);
}
bool are_unit(const float* q, std::size_t count, float slack) {
    for (std::size_t i = 0; i < count; ++i, q += 4)
        if (!(std::fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0f) <= slack)) return false;
    return true;
}

std::string skeleton_problem(const Skeleton& s) {
    const std::size_t count = s.parents.size();
    if (count == 0 || count > kMostJoints) return fmt::format("{} joints; expected 1 to {}", count, kMostJoints);
    if (s.names.size() != count || s.translations.size() != count || s.rotations.size() != count ||
        s.scales.size() != count)
        return fmt::format("a skeleton of {} joints whose arrays differ in length; expected one of each", count);
    for (std::size_t j = 0; j < count; ++j) {
        if (s.parents[j] != kNoJoint && s.parents[j] >= j)
            return fmt::format("joint {} hangs on {}; expected a joint before it", j, s.parents[j]);
        if (s.names[j].size() > kMaxNameBytes)
            return fmt::format("joint {}: a name of {} bytes; expected at most {}", j, s.names[j].size(),
                               kMaxNameBytes);
    }
    if (!are_within(s.translations) || !are_within(s.scales) ||
        !are_unit(reinterpret_cast<const float*>(s.rotations.data()), count, 1e-3f))
        return "a rest pose with numbers that are none; expected finite ones and unit quaternions";
    return {};
}

std::string track_problem(const Track& track, const Clip& clip, std::size_t joint_count) {
    if (track.joint >= joint_count) return fmt::format("joint {} of {}", track.joint, joint_count);
    if (track.path > TrackPath::scale || track.interpolation > Interpolation::cubic)
        return "a path or interpolation that is unknown; expected those of animation.h";
    const std::uint64_t times = track.even ? 2 : track.key_count;
    const std::uint64_t values = std::uint64_t(track.key_count) * components_of(track.path) *
                                 (track.interpolation == Interpolation::cubic ? 3 : 1);
    if (track.key_count == 0 || track.first_time + times > clip.times.size() ||
        track.first_value + values > clip.values.size())
        return fmt::format("{} keys that lie outside the clip's; expected at least one, all inside", track.key_count);
    const float* time = clip.times.data() + track.first_time;
    if (track.even) {
        if (!(time[0] >= 0.0f && time[0] <= kMaxNumber && time[1] > 0.0f && time[1] <= kMaxNumber))
            return "even keys that do not ascend; expected a start from 0 and a positive step";
    } else {
        for (std::uint32_t k = 0; k < track.key_count; ++k)
            if (!(time[k] >= 0.0f && time[k] <= kMaxNumber && (k == 0 || time[k] > time[k - 1])))
                return fmt::format("key {} at {} s; expected ascending times from 0", k, time[k]);
    }
    return {};
}

std::string clip_problem(const Clip& clip, std::size_t joint_count) {
    if (clip.name.empty() || clip.name.size() > kMaxNameBytes)
        return fmt::format("a clip's name of {} bytes; expected 1 to {}", clip.name.size(), kMaxNameBytes);
    if (!(clip.duration_s >= 0.0f && clip.duration_s <= kMaxNumber))
        return fmt::format("clip {}: {} s long; expected a finite number from 0", clip.name, clip.duration_s);
    if (!are_within(clip.values)) return fmt::format("clip {}: a value that is not finite", clip.name);
    for (std::size_t t = 0; t < clip.tracks.size(); ++t) {
        if (std::string problem = track_problem(clip.tracks[t], clip, joint_count); !problem.empty())
            return fmt::format("clip {}: track {}: {}", clip.name, t, problem);
        if (t == 0) continue;
        const Track &a = clip.tracks[t - 1], &b = clip.tracks[t];
        if (a.joint > b.joint || (a.joint == b.joint && a.path >= b.path))
            return fmt::format("clip {}: track {} is out of order; expected them by joint and path", clip.name, t);
    }
    return {};
}

bool is_affine(const Mat4x3& m) {
    return are_within(&m[0][0], 12);
}

std::string skin_problem(const Skin& skin, std::size_t joint_count, std::span<const Mesh> meshes) {
    if (skin.mesh >= meshes.size()) return fmt::format("mesh {} of {}", skin.mesh, meshes.size());
    if (skin.joints.empty() || skin.joints.size() > kMostJoints || skin.joints.size() != skin.joint_from_mesh.size())
        return fmt::format("{} joints with {} matrices; expected one each", skin.joints.size(),
                           skin.joint_from_mesh.size());
    for (const std::uint32_t joint : skin.joints)
        if (joint >= joint_count) return fmt::format("joint {} of {}", joint, joint_count);
    for (const Mat4x3& m : skin.joint_from_mesh)
        if (!is_affine(m)) return "an inverse bind matrix that is not finite";
    if (skin.influences < 1 || skin.influences > kMostInfluences)
        return fmt::format("{} influences; expected 1 to {}", skin.influences, kMostInfluences);
    const std::size_t entries = std::size_t(meshes[skin.mesh].vertex_count) * skin.influences;
    if (skin.vertex_joints.size() != entries || skin.vertex_weights.size() != entries)
        return fmt::format("{} joints and {} weights; expected {} for the mesh's vertices", skin.vertex_joints.size(),
                           skin.vertex_weights.size(), entries);
    for (const std::uint16_t joint : skin.vertex_joints)
        if (joint >= skin.joints.size())
            return fmt::format("a vertex follows joint {} of {}", joint, skin.joints.size());
    for (std::size_t first = 0; first < entries; first += skin.influences) {
        float sum = 0.0f;
        for (std::size_t i = first; i < first + skin.influences; ++i) {
            if (!(skin.vertex_weights[i] >= 0.0f)) return "a weight below 0; expected [0, 1]";
            sum += skin.vertex_weights[i];
        }
        if (!(std::fabs(sum - 1.0f) <= 1e-3f))
            return fmt::format("the weights of vertex {} sum to {}; expected 1", first / skin.influences, sum);
    }
    return {};
}

std::string model_problem(const AnimatedModel& model, std::span<const Mesh> meshes, std::set<std::uint32_t>& skinned) {
    if (model.name.size() > kMaxNameBytes) return fmt::format("a name of {} bytes", model.name.size());
    if (std::string problem = skeleton_problem(model.skeleton); !problem.empty()) return problem;
    const std::size_t joints = model.skeleton.size();
    std::set<std::string_view> names;
    for (const Clip& clip : model.clips) {
        if (std::string problem = clip_problem(clip, joints); !problem.empty()) return problem;
        if (!names.insert(clip.name).second)
            return fmt::format("two clips are called \"{}\"; expected names of their own", clip.name);
    }
    for (std::size_t i = 0; i < model.parts.size(); ++i)
        if (const RigidPart& part = model.parts[i];
            part.mesh >= meshes.size() || part.joint >= joints || !is_affine(part.joint_from_mesh))
            return fmt::format("part {}: mesh {} of {} on joint {} of {}; expected both to be there and a finite map",
                               i, part.mesh, meshes.size(), part.joint, joints);
    for (std::size_t i = 0; i < model.skins.size(); ++i) {
        if (std::string problem = skin_problem(model.skins[i], joints, meshes); !problem.empty())
            return fmt::format("skin {}: {}", i, problem);
        if (!skinned.insert(model.skins[i].mesh).second)
            return fmt::format("skin {}: mesh {} has a skin already; expected one", i, model.skins[i].mesh);
    }
    return {};
}

std::string instance_problem(const AnimatedInstance& instance, const AnimationSet& set) {
    if (instance.model >= set.models.size()) return fmt::format("model {} of {}", instance.model, set.models.size());
    const auto within = [](double x) { return std::fabs(x) <= kMaxWorldCoordinate; };
    if (!within(instance.position.x) || !within(instance.position.y) || !within(instance.position.z))
        return fmt::format("a position beyond {:g} m of the origin", kMaxWorldCoordinate);
    const double volume = glm::determinant(DMat3(instance.world_from_model));
    if (!are_within(&instance.world_from_model[0][0], 9, 1e6f) || !(std::fabs(volume) >= 1e-30))
        return "a matrix that cannot be inverted; expected rotation and scale";
    if (instance.clip != kNoClip && instance.clip >= set.models[instance.model].clips.size())
        return fmt::format("clip {} of {}", instance.clip, set.models[instance.model].clips.size());
    if (!(instance.phase >= 0.0 && instance.phase < 1.0))
        return fmt::format("phase {}; expected [0, 1)", instance.phase);
    return {};
}

}  // namespace

std::optional<WorldProblem> find_animation_problem(const AnimationSet& set, std::span<const Mesh> meshes) {
    std::set<std::uint32_t> skinned;
    for (std::size_t m = 0; m < set.models.size(); ++m)
        if (std::string what = model_problem(set.models[m], meshes, skinned); !what.empty())
            return WorldProblem{"animation", m, fmt::format("model \"{}\": {}", set.models[m].name, what)};
    for (std::size_t i = 0; i < set.instances.size(); ++i)
        if (std::string what = instance_problem(set.instances[i], set); !what.empty())
            return WorldProblem{"animation", set.models.size() + i, fmt::format("instance {}: {}", i, what)};
    return std::nullopt;
}

}  // namespace ff::scene
