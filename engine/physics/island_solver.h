#pragma once
// Bodies that touch, made to move so that they do not pass into each other: Bullet's sequential impulses over one
// island at a time, relative to a point near it.
//
// Based on: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005, as in Coumans, Bullet Physics 3.24. Ours
// differs: no impulse is kept from tick to tick (warm starting), so that a tick needs no more than where things are and
// how they move; more iterations make up for it.

#include <memory>
#include <span>
#include <vector>

#include "engine/physics/contacts.h"

namespace ff::physics {

/// A dynamic body as an island sees it; the solver writes what it says.
struct SolverBody {
    DVec3 position{0.0};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};
    float mass_kg = 0.0f;  ///< 0: not moved by contacts, but its velocities count (kinematic, static)
    Vec3 inertia{0.0f};    ///< kg m^2, about the axes
    Vec3 velocity{0.0f};   ///< read and written
    Vec3 spin{0.0f};       ///< read and written
    DVec3 shift{0.0};      ///< written: what parts it from what it was in
    bool turned = false;   ///< written: whether `rotation` was, too
};

/// Contacts of two bodies of a step, by their places in the span that solve() is given.
struct SolverPair {
    static constexpr std::uint32_t kScene = 0xFFFFFFFFu;
    std::uint32_t a = 0, b = kScene;
    std::uint32_t first_contact = 0, contact_count = 0;
    float friction = 0.0f, restitution = 0.0f;
    float rolling_m = 0.0f;  ///< the lever at which the contact's force works against rolling
};

class IslandSolver {
  public:
    IslandSolver(double tick_s, int iterations);
    ~IslandSolver();

    /// @param members  of `bodies`: the dynamic ones of this island, ascending
    /// @param pairs    their contacts, in an order that does not depend on how they were found
    void solve(std::span<SolverBody> bodies, std::span<const std::uint32_t> members, std::span<const SolverPair> pairs,
               std::span<const Contact> contacts);

  private:
    struct Impl;
    int iterations_;
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::physics
