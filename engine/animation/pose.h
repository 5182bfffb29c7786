#pragma once
// A pose: where each joint of a skeleton stands relative to its parent. Structure of arrays.

#include <span>
#include <vector>

#include "engine/scene/animation.h"

namespace ff::animation {

using scene::Mat4x3;
using scene::Quat;

struct Pose {
    std::vector<Vec3> translations;
    std::vector<Quat> rotations;  ///< unit
    std::vector<Vec3> scales;

    [[nodiscard]] std::size_t size() const { return translations.size(); }
    /// Takes the skeleton's rest pose; allocates only where it had less room.
    void set_rest(const scene::Skeleton& skeleton);
};

/// One of the poses that a blend is made of; borrowed.
struct WeightedPose {
    const Pose* pose = nullptr;
    float weight = 0.0f;  ///< from 0; only proportions count
};

/// The weighted mean, by joint: translations and scales linearly, rotations by the normalised mean of quaternions, each
/// turned to the hemisphere of the first pose that has a weight. Weights that sum to 0 leave `out` as it is.
/// @param out  of the same size; may be none of the poses
/// Source: Kavan, Zara, "Spherical Blend Skinning", I3D 2005, section 4 (the mean), for two poses known as nlerp.
void blend_poses(std::span<const WeightedPose> poses, Pose& out);

/// Moves `base` towards `over` by `weight` times each joint's own share, as blend_poses does for two.
/// @param weight  [0, 1]
/// @param mask    [joint], [0, 1]; empty: 1 for all
void blend_onto(Pose& base, const Pose& over, float weight, std::span<const float> mask = {});

/// 1 for a joint and all that hangs on it, 0 for the others: a layer's mask.
/// @param root  kNoJoint: nothing
[[nodiscard]] std::vector<float> mask_below(const scene::Skeleton& skeleton, std::uint32_t root);

/// Where the joints stand in the model: model_from_joint, parents first.
/// @param out  [joint]
void find_joint_matrices(const scene::Skeleton& skeleton, const Pose& pose, std::span<Mat4x3> out);

/// Affine maps, one after the other: (a * b) p = a (b p).
[[nodiscard]] Mat4x3 product(const Mat4x3& a, const Mat4x3& b);

}  // namespace ff::animation
