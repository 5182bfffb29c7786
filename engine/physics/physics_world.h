#pragma once
// The collision world: the static scene, characters and rigid bodies, stepped in ticks of one length.
//
// A tick is a function of state() and the calls since the last tick, bit for bit: contacts are found anew, pairs and
// islands are ordered by ids, nothing depends on addresses, time or threads.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/result.h"
#include "engine/physics/character.h"
#include "engine/physics/types.h"
#include "engine/scene/static_scene.h"

namespace ff::physics {

struct PhysicsSettings {
    double tick_s = 1.0 / 120.0;            ///< length of a step, [1e-4, 0.1]
    Vec3 gravity_m_s2{0.0f, -9.81f, 0.0f};  ///< on bodies; each component within 1000
    int solver_iterations = 12;             ///< of a body alone, a third more for each that it touches; [3, 200]
    /// Dynamic bodies farther than this from every character and viewer are held where they are, as if time stood still
    /// for them. Without any none is held. (0, +inf]
    double active_range_m = 300.0;
};

/// Work of one step.
struct StepStats {
    std::uint32_t characters = 0;
    std::uint32_t bodies_stepped = 0;  ///< dynamic, awake, in range
    std::uint32_t bodies_asleep = 0;   ///< dynamic
    std::uint32_t bodies_held = 0;     ///< awake, out of range
    std::uint32_t islands = 0;
    std::uint32_t contact_points = 0;
    std::uint32_t triangles_tested = 0;  ///< of the static scene and of mesh bodies
};

/// Threads: const members from many at once; the others from one, while nobody reads.
/// Memory: nothing is made of the static scene, its own hierarchies are walked.
class PhysicsWorld {
  public:
    /// @param scene  borrowed, must outlive this
    /// FF_CHECKs the ranges of the settings.
    explicit PhysicsWorld(const scene::StaticScene& scene, const PhysicsSettings& settings = {});
    ~PhysicsWorld();
    PhysicsWorld(const PhysicsWorld&) = delete;
    PhysicsWorld& operator=(const PhysicsWorld&) = delete;

    // Every call that takes numbers refuses (usage) what is not finite or out of the stated range, and changes nothing
    // then; so does one that names a body or character that is not alive.

    /// Errors: also a hull of fewer than 4 points that are not in one plane; a dynamic body of shape mesh.
    Result<BodyId> add_body(const BodyDesc& desc);
    /// @return false where it is not alive. Wakes what touched it.
    bool remove_body(BodyId body);
    [[nodiscard]] bool is_alive(BodyId body) const;
    /// @param body  must be alive
    [[nodiscard]] BodyState body(BodyId body) const;
    /// Puts it there at once, awake; velocities stay.
    Status set_pose(BodyId body, const Pose& pose);
    /// Dynamic bodies only.
    Status set_velocity(BodyId body, const Vec3& velocity_m_s, const Vec3& spin_rad_s);
    /// Dynamic bodies only. Wakes it.
    Status apply_impulse(BodyId body, const Vec3& impulse_n_s, const WorldPos& at);
    /// Kinematic bodies only: the next step moves it there, and pushes and carries what is in its way. Without another
    /// call it stops there.
    Status move_kinematic(BodyId body, const Pose& target);

    Result<CharacterId> add_character(const CharacterDesc& desc);
    bool remove_character(CharacterId character);
    [[nodiscard]] bool is_alive(CharacterId character) const;
    Status set_input(CharacterId character, const CharacterInput& input);
    /// Puts it there at once, at rest.
    Status set_position(CharacterId character, const WorldPos& feet);
    /// @param character  must be alive
    [[nodiscard]] CharacterState character(CharacterId character) const;

    /// One tick. Allocates nothing once its scratch has grown to what the scene asks for.
    /// @param viewers  bodies near them are stepped as those near characters are
    StepStats step(std::span<const WorldPos> viewers = {});
    [[nodiscard]] std::uint64_t tick() const;  ///< steps made so far, saved with the state
    [[nodiscard]] const PhysicsSettings& settings() const;
    /// Dynamic bodies that the last step moved, in order of their slots.
    [[nodiscard]] std::span<const BodyId> moved_bodies() const;

    // Queries see poses as of the last step. A ray that is not finite, or of no length, meets nothing.

    /// First surface along a ray. @param direction  any length  @param max_m  up to here; may be +inf
    [[nodiscard]] std::optional<Hit> cast_ray(const WorldPos& from, const Vec3& direction, double max_m,
                                              const QueryFilter& filter = {}) const;
    /// First surface that a sphere of `radius_m` meets whose centre moves along a ray. One that starts within a
    /// surface meets it at distance 0.
    [[nodiscard]] std::optional<Hit> cast_sphere(const WorldPos& from, float radius_m, const Vec3& direction,
                                                 double max_m, const QueryFilter& filter = {}) const;
    /// Whether nothing lies between two points, however far apart.
    [[nodiscard]] bool can_see(const WorldPos& from, const WorldPos& to, const QueryFilter& filter = {}) const;
    /// Bodies that a sphere touches, by ascending slot, appended to `out`.
    void bodies_near(const WorldPos& center, float radius_m, std::vector<BodyId>& out) const;

    /// Everything that lives here, exactly: another PhysicsWorld of the same scene and settings that takes it goes on
    /// bit for bit like this one. Versioned.
    [[nodiscard]] std::vector<std::byte> state() const;
    /// Replaces everything that lives here. Errors (bad_input): damaged, another version, a mesh that the scene has
    /// not, other settings; nothing has changed then.
    Status set_state(std::span<const std::byte> state);
    /// Of state(): equal exactly where state() is, but for collisions of 64 bits.
    [[nodiscard]] std::uint64_t hash() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::physics
