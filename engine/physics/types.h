#pragma once
// What bodies are made of and how queries answer. SI units; positions in the world in double, everything else in float.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>

#include "engine/math/types.h"

namespace ff::physics {

/// A handle of a PhysicsWorld: index of a slot, and which of its successive inhabitants is meant; a default one is
/// null. Saved with the state, so it means the same body after a load.
struct BodyId {
    std::uint32_t index = 0;
    std::uint32_t generation = 0;  ///< from 1; 0 is null

    explicit operator bool() const { return generation != 0; }
    friend bool operator==(const BodyId&, const BodyId&) = default;
};
struct CharacterId {
    std::uint32_t index = 0;
    std::uint32_t generation = 0;

    explicit operator bool() const { return generation != 0; }
    friend bool operator==(const CharacterId&, const CharacterId&) = default;
};

struct Pose {
    WorldPos position{0.0};                      ///< of the shape's origin
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};  ///< near unit; normalised when given
};

enum class ShapeKind : std::uint8_t {
    box,
    sphere,
    capsule,  ///< along y
    hull,     ///< the convex hull of a mesh of the scene
    mesh,     ///< the triangles of a mesh of the scene themselves, masked ones apart; kinematic bodies only
};

/// Which numbers count depends on the kind; see the functions below.
struct Shape {
    ShapeKind kind = ShapeKind::box;
    Vec3 half_extents_m{0.5f};   ///< box: (0, 1000]
    float radius_m = 0.5f;       ///< sphere, capsule: (0, 1000]
    float half_height_m = 0.5f;  ///< capsule: half the distance of its two centres, [0, 1000]
    std::uint32_t mesh = 0;      ///< hull, mesh: index of StaticScene::meshes
    Mat3 body_from_mesh{1.0f};   ///< hull, mesh: scale, mirror; never singular
};
[[nodiscard]] inline Shape box_shape(const Vec3& half_extents_m) {
    return {.kind = ShapeKind::box, .half_extents_m = half_extents_m};
}
[[nodiscard]] inline Shape sphere_shape(float radius_m) {
    return {.kind = ShapeKind::sphere, .radius_m = radius_m};
}
[[nodiscard]] inline Shape capsule_shape(float radius_m, float half_height_m) {
    return {.kind = ShapeKind::capsule, .radius_m = radius_m, .half_height_m = half_height_m};
}
[[nodiscard]] inline Shape hull_shape(std::uint32_t mesh, const Mat3& body_from_mesh = Mat3(1.0f)) {
    return {.kind = ShapeKind::hull, .mesh = mesh, .body_from_mesh = body_from_mesh};
}
[[nodiscard]] inline Shape mesh_shape(std::uint32_t mesh, const Mat3& body_from_mesh = Mat3(1.0f)) {
    return {.kind = ShapeKind::mesh, .mesh = mesh, .body_from_mesh = body_from_mesh};
}

enum class Motion : std::uint8_t {
    dynamic,    ///< moved by gravity, contacts and impulses
    kinematic,  ///< moved by move_kinematic alone: doors, carts, boats. Pushes, and is never pushed
};

struct BodyDesc {
    Shape shape;
    Motion motion = Motion::dynamic;
    Pose pose;
    Vec3 velocity_m_s{0.0f};
    Vec3 spin_rad_s{0.0f};
    float mass_kg = 10.0f;     ///< dynamic: [1e-3, 1e6]
    float friction = 0.6f;     ///< Coulomb's; two bodies' are multiplied, the static scene's is 1. [0, 10]
    float restitution = 0.0f;  ///< two bodies' are multiplied, the static scene's is 1. [0, 1]
    /// Of spheres and capsules: the slope, as a tangent, on which one stays that does not roll yet. [0, 1]
    float rolling_resistance = 0.03f;
    float linear_damping = 0.02f;  ///< part of the velocity lost a second, [0, 1]
    float angular_damping = 0.1f;  ///< [0, 1]
    bool asleep = false;           ///< put where it is until something touches it
    std::uint64_t user = 0;        ///< the caller's, e.g. an entity; not looked at
};

struct BodyState {
    Pose pose;
    Vec3 velocity_m_s{0.0f};  ///< of the centre of mass
    Vec3 spin_rad_s{0.0f};
    bool asleep = false;
    std::uint64_t user = 0;
};

/// What a query meets.
struct Hit {
    double distance_m = 0.0;                   ///< along the ray; for a swept sphere, how far its centre got
    WorldPos point{0.0};                       ///< on the surface
    Vec3 normal{0.0f};                         ///< unit, towards where the ray came from
    BodyId body;                               ///< null: the static scene
    std::uint32_t instance = 0, triangle = 0;  ///< static scene, and bodies of shape mesh (triangle only)
};

/// What queries look at. Masked foliage is never met.
struct QueryFilter {
    bool static_scene = true;
    bool bodies = true;
    BodyId except;  ///< e.g. what the player carries
};

}  // namespace ff::physics
