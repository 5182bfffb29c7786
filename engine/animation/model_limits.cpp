#include "engine/animation/model_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/animation/pose.h"
#include "engine/animation/sample_clip.h"

namespace ff::animation {
namespace {

using scene::Clip;
using scene::Interpolation;
using scene::Track;
using scene::TrackPath;

constexpr double kSamplesPerSecond = 64.0;
constexpr int kMostSamples = 4096;

std::array<Vec3, 8> corners_of(const Box3& box) {
    std::array<Vec3, 8> out;
    for (unsigned i = 0; i < 8; ++i)
        out[i] = {(i & 1) != 0 ? box.high.x : box.low.x, (i & 2) != 0 ? box.high.y : box.low.y,
                  (i & 4) != 0 ? box.high.z : box.low.z};
    return out;
}

Vec3 transformed(const Mat4x3& m, const Vec3& p) {
    return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}

float farthest(const Mat4x3& m, const Box3& box) {
    float out = 0.0f;
    if (!box.is_empty())
        for (const Vec3& corner : corners_of(box)) out = std::max(out, glm::length(transformed(m, corner)));
    return out;
}

/// The greatest length of a track's values; for scales the greatest number.
float greatest(const Clip& clip, const Track& track) {
    const auto size_of = [&](const float* v) {
        if (track.path == TrackPath::scale) return std::max({std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])});
        return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    };
    const bool is_cubic = track.interpolation == Interpolation::cubic;
    float value = 0.0f, tangent = 0.0f;
    for (std::uint32_t k = 0; k < track.key_count; ++k) {
        const float* key = clip.values.data() + track.first_value + std::size_t(k) * (is_cubic ? 9 : 3);
        value = std::max(value, size_of(is_cubic ? key + 3 : key));
        if (is_cubic) tangent = std::max({tangent, size_of(key), size_of(key + 6)});
    }
    // Hermite's tangents weigh at most 4/27 each.
    return value + 2.0f * (4.0f / 27.0f) * clip.duration_s * tangent;
}

/// Calls visit(model_from_mesh, box) for each box of which parts and skins consist.
template <class Visit>
void each_box(const scene::AnimatedModel& model, std::span<const scene::Mesh> meshes, std::span<const SkinTables> skins,
              Visit&& visit) {
    for (const scene::RigidPart& part : model.parts) visit(part.joint, part.joint_from_mesh, meshes[part.mesh].bounds);
    for (std::size_t s = 0; s < skins.size(); ++s)
        for (std::size_t j = 0; j < model.skins[s].joints.size(); ++j)
            visit(model.skins[s].joints[j], model.skins[s].joint_from_mesh[j], skins[s].joint_boxes[j]);
}

}  // namespace

float find_reach(const scene::AnimatedModel& model, std::span<const scene::Mesh> meshes,
                 std::span<const SkinTables> skins) {
    const scene::Skeleton& skeleton = model.skeleton;
    std::vector<float> offset(skeleton.size()), scale(skeleton.size());
    for (std::uint32_t j = 0; j < skeleton.size(); ++j) {
        const Vec3 s = glm::abs(skeleton.scales[j]);
        offset[j] = glm::length(skeleton.translations[j]);
        scale[j] = std::max({s.x, s.y, s.z});
    }
    for (const Clip& clip : model.clips)
        for (const Track& track : clip.tracks) {
            if (track.path == TrackPath::rotation) continue;
            float& most = track.path == TrackPath::scale ? scale[track.joint] : offset[track.joint];
            most = std::max(most, greatest(clip, track));
        }
    for (std::uint32_t j = 0; j < skeleton.size(); ++j) {
        const std::uint32_t parent = skeleton.parents[j];
        if (parent == scene::kNoJoint) continue;
        offset[j] = offset[parent] + scale[parent] * offset[j];
        scale[j] *= scale[parent];
    }
    float reach = 0.0f;
    each_box(model, meshes, skins, [&](std::uint32_t joint, const Mat4x3& joint_from_mesh, const Box3& box) {
        if (!box.is_empty()) reach = std::max(reach, offset[joint] + scale[joint] * farthest(joint_from_mesh, box));
    });
    return reach;
}

float find_speed(const scene::AnimatedModel& model, const Clip& clip, std::span<const scene::Mesh> meshes,
                 std::span<const SkinTables> skins) {
    const int steps = int(std::min(double(clip.duration_s) * kSamplesPerSecond, double(kMostSamples))) + 1;
    const float step_s = clip.duration_s / float(steps);
    if (!(step_s > 0.0f)) return 0.0f;
    Pose pose;
    std::vector<Mat4x3> joints(model.skeleton.size());
    std::vector<Vec3> before, now;
    float farthest_step = 0.0f;
    for (int i = 0; i <= steps; ++i) {
        pose.set_rest(model.skeleton);
        sample_clip(clip, float(i) * step_s, pose);
        find_joint_matrices(model.skeleton, pose, joints);
        now.clear();
        each_box(model, meshes, skins, [&](std::uint32_t joint, const Mat4x3& joint_from_mesh, const Box3& box) {
            if (box.is_empty()) return;
            const Mat4x3 model_from_mesh = product(joints[joint], joint_from_mesh);
            for (const Vec3& corner : corners_of(box)) now.push_back(transformed(model_from_mesh, corner));
        });
        for (std::size_t p = 0; p < before.size(); ++p)
            farthest_step = std::max(farthest_step, glm::length(now[p] - before[p]));
        before.swap(now);
    }
    return 1.25f * farthest_step / step_s;
}

void find_skin_matrices(const scene::Skin& skin, std::span<const Mat4x3> model_from_joint,
                        std::span<JointColumns> out) {
    for (std::size_t j = 0; j < skin.joints.size(); ++j) {
        const Mat4x3 m = product(model_from_joint[skin.joints[j]], skin.joint_from_mesh[j]);
        for (int c = 0; c < 4; ++c) {
            out[j].column[c][0] = m[c].x;
            out[j].column[c][1] = m[c].y;
            out[j].column[c][2] = m[c].z;
            out[j].column[c][3] = 0.0f;
        }
    }
}

}  // namespace ff::animation
