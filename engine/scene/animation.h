#pragma once
// Models that move of themselves, as a pack holds them: a skeleton (the glTF node hierarchy), clips that turn its
// joints, rigid parts that hang on joints, and skins whose vertices follow several joints. Plain data; what plays it is
// engine/animation.
//
// Spaces: model (the glTF scene's), joint (a node's own), mesh (a mesh's vertices). For a skin the matrices
// joint_from_mesh are glTF's inverse bind matrices, and a vertex lies at
//     sum over its influences: weight * model_from_joint * joint_from_mesh * vertex        in model space.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "engine/math/types.h"

namespace ff::scene {

using Quat = glm::quat;
using Mat4x3 = glm::mat4x3;  ///< an affine map: three columns of its linear part, then the translation

inline constexpr std::uint32_t kNoJoint = 0xFFFFFFFFu;
inline constexpr std::uint32_t kNoClip = 0xFFFFFFFFu;

/// The hierarchy and its rest pose; arrays by joint. A joint's transform scales, then turns, then moves.
struct Skeleton {
    std::vector<std::string> names;      ///< as in the source; may be empty or repeat
    std::vector<std::uint32_t> parents;  ///< less than the joint's own number; kNoJoint: hangs on the model itself
    std::vector<Vec3> translations;      ///< metres
    std::vector<Quat> rotations;         ///< unit
    std::vector<Vec3> scales;

    [[nodiscard]] std::uint32_t size() const { return std::uint32_t(parents.size()); }
};

enum class TrackPath : std::uint8_t { translation, rotation, scale };
enum class Interpolation : std::uint8_t { step, linear, cubic };

/// Numbers of one value of a track: 4 of a quaternion (x, y, z, w), else 3.
[[nodiscard]] constexpr std::uint32_t components_of(TrackPath path) {
    return path == TrackPath::rotation ? 4 : 3;
}

/// One property of one joint over time; before the first key and after the last it stays what it is there.
struct Track {
    std::uint32_t joint = 0;
    TrackPath path = TrackPath::translation;
    Interpolation interpolation = Interpolation::linear;  ///< linear: spherical for rotations
    bool even = false;              ///< keys at times[first_time] + i * times[first_time + 1]; else a time each
    std::uint32_t first_time = 0;   ///< in Clip::times
    std::uint32_t key_count = 0;    ///< at least 1
    std::uint32_t first_value = 0;  ///< in Clip::values; a cubic key has three values: in-tangent, value, out-tangent

    friend bool operator==(const Track&, const Track&) = default;
};

struct Clip {
    std::string name;           ///< not empty; unique within a model
    float duration_s = 0.0f;    ///< time of the last key
    std::vector<Track> tracks;  /// by joint, then by path; no two of the same
    std::vector<float> times;   ///< seconds from 0, ascending within a track
    std::vector<float> values;
};

/// A mesh that moves with a joint as it is.
struct RigidPart {
    std::uint32_t mesh = 0;  ///< of StaticScene::meshes
    std::uint32_t joint = 0;
    Mat4x3 joint_from_mesh{1.0f};
};

inline constexpr std::uint32_t kMostInfluences = 8;

/// A mesh whose vertices follow joints.
struct Skin {
    std::uint32_t mesh = 0;                    ///< of StaticScene::meshes
    std::vector<std::uint32_t> joints;         ///< of the skeleton
    std::vector<Mat4x3> joint_from_mesh;       ///< same length
    std::uint32_t influences = 1;              ///< of each vertex, [1, kMostInfluences]
    std::vector<std::uint16_t> vertex_joints;  ///< [vertex][influence], index into `joints`
    std::vector<float> vertex_weights;         ///< same; each vertex's sum to 1, greatest first
};

struct AnimatedModel {
    std::string name;
    Skeleton skeleton;
    std::vector<Clip> clips;
    std::vector<RigidPart> parts;
    std::vector<Skin> skins;
};

/// An animated model placed where the game starts.
struct AnimatedInstance {
    std::uint32_t model = 0;
    WorldPos position{0.0};
    Mat3 world_from_model{1.0f};   ///< rotation, scale, mirror; never singular
    std::uint32_t clip = kNoClip;  ///< that it plays; kNoClip: rest pose
    double phase = 0.0;            ///< part of the clip that has passed at the start, [0, 1)

    friend bool operator==(const AnimatedInstance&, const AnimatedInstance&) = default;
};

/// All that moves of itself in a world.
struct AnimationSet {
    std::vector<AnimatedModel> models;
    std::vector<AnimatedInstance> instances;
};

/// The clip of that name, or kNoClip.
[[nodiscard]] std::uint32_t find_clip(const AnimatedModel& model, std::string_view name);
/// The first joint of that name, or kNoJoint.
[[nodiscard]] std::uint32_t find_joint(const Skeleton& skeleton, std::string_view name);

}  // namespace ff::scene
