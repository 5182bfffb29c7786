#include "engine/animation/pose.h"

#include <algorithm>
#include <cmath>

#include "engine/core/check.h"

namespace ff::animation {
namespace {

Quat normalized(const Quat& q) {
    const float squared = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    // Poses half a turn apart with equal weights cancel out: any rotation is as good then.
    if (!(squared > 1e-12f)) return {1.0f, 0.0f, 0.0f, 0.0f};
    const float s = 1.0f / std::sqrt(squared);
    return {q.w * s, q.x * s, q.y * s, q.z * s};
}

/// sum += weight * q, on the side of `towards`.
void add_turned(Quat& sum, const Quat& q, float weight, const Quat& towards) {
    const float dot = q.x * towards.x + q.y * towards.y + q.z * towards.z + q.w * towards.w;
    const float signed_weight = dot < 0.0f ? -weight : weight;
    sum.x += signed_weight * q.x;
    sum.y += signed_weight * q.y;
    sum.z += signed_weight * q.z;
    sum.w += signed_weight * q.w;
}

Mat4x3 matrix_of(const Vec3& translation, const Quat& q, const Vec3& scale) {
    const float x = q.x, y = q.y, z = q.z, w = q.w;
    return {Vec3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)) * scale.x,
            Vec3(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)) * scale.y,
            Vec3(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)) * scale.z, translation};
}

}  // namespace

void Pose::set_rest(const scene::Skeleton& skeleton) {
    translations.assign(skeleton.translations.begin(), skeleton.translations.end());
    rotations.assign(skeleton.rotations.begin(), skeleton.rotations.end());
    scales.assign(skeleton.scales.begin(), skeleton.scales.end());
}

void blend_poses(std::span<const WeightedPose> poses, Pose& out) {
    float sum = 0.0f;
    const Pose* first = nullptr;
    for (const WeightedPose& p : poses) {
        sum += p.weight;
        if (first == nullptr && p.weight > 0.0f) first = p.pose;
    }
    if (!(sum > 0.0f)) return;
    for (std::size_t j = 0; j < out.size(); ++j) {
        Vec3 translation(0.0f), scale(0.0f);
        Quat rotation(0.0f, 0.0f, 0.0f, 0.0f);
        for (const WeightedPose& p : poses) {
            if (!(p.weight > 0.0f)) continue;
            FF_CHECK(p.pose->size() == out.size() && p.pose != &out, "{} joints, {}", p.pose->size(), out.size());
            translation += p.weight * p.pose->translations[j];
            scale += p.weight * p.pose->scales[j];
            add_turned(rotation, p.pose->rotations[j], p.weight, first->rotations[j]);
        }
        out.translations[j] = translation / sum;
        out.scales[j] = scale / sum;
        out.rotations[j] = normalized(rotation);
    }
}

void blend_onto(Pose& base, const Pose& over, float weight, std::span<const float> mask) {
    for (std::size_t j = 0; j < base.size(); ++j) {
        const float w = weight * (j < mask.size() ? mask[j] : mask.empty() ? 1.0f : 0.0f);
        if (!(w > 0.0f)) continue;
        base.translations[j] += w * (over.translations[j] - base.translations[j]);
        base.scales[j] += w * (over.scales[j] - base.scales[j]);
        const Quat from = base.rotations[j];
        Quat sum(from.w * (1.0f - w), from.x * (1.0f - w), from.y * (1.0f - w), from.z * (1.0f - w));
        add_turned(sum, over.rotations[j], w, from);
        base.rotations[j] = normalized(sum);
    }
}

std::vector<float> mask_below(const scene::Skeleton& skeleton, std::uint32_t root) {
    std::vector<float> mask(skeleton.size(), 0.0f);
    if (root >= skeleton.size()) return mask;
    mask[root] = 1.0f;
    for (std::uint32_t j = root + 1; j < skeleton.size(); ++j)
        if (skeleton.parents[j] != scene::kNoJoint) mask[j] = mask[skeleton.parents[j]];
    return mask;
}

Mat4x3 product(const Mat4x3& a, const Mat4x3& b) {
    const auto turned = [&](const Vec3& v) { return a[0] * v.x + a[1] * v.y + a[2] * v.z; };
    return {turned(b[0]), turned(b[1]), turned(b[2]), turned(b[3]) + a[3]};
}

void find_joint_matrices(const scene::Skeleton& skeleton, const Pose& pose, std::span<Mat4x3> out) {
    for (std::uint32_t j = 0; j < skeleton.size(); ++j) {
        const Mat4x3 local = matrix_of(pose.translations[j], pose.rotations[j], pose.scales[j]);
        const std::uint32_t parent = skeleton.parents[j];
        out[j] = parent == scene::kNoJoint ? local : product(out[parent], local);
    }
}

}  // namespace ff::animation
