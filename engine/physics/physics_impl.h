#pragma once
// What PhysicsWorld holds, for the files that carry it out: its calls, the step, the state.

#include <string>
#include <vector>

#include "engine/physics/body_store.h"
#include "engine/physics/character_controller.h"
#include "engine/physics/contacts.h"
#include "engine/physics/island_solver.h"
#include "engine/physics/physics_world.h"

namespace ff::physics {

struct PhysicsWorld::Impl {
    Impl(const scene::StaticScene& scene, const PhysicsSettings& settings);

    const scene::StaticScene& scene;
    const PhysicsSettings settings;
    std::uint64_t tick = 0;

    BodyStore bodies;
    std::vector<Character> characters;
    std::vector<std::uint32_t> free_characters;  ///< last in, first out

    // By slot, ascending; derived from the bodies.
    std::vector<std::uint32_t> awake;  ///< dynamic
    std::vector<std::uint32_t> kinematic;
    std::uint32_t asleep_count = 0;
    std::uint64_t asleep_sum = 0;  ///< of the hashes of those that sleep

    CharacterController controller;
    ContactFinder finder;
    IslandSolver solver;

    // The last step's, for the caller.
    std::vector<BodyId> moved;

    // Scratch of the step.
    std::vector<std::uint32_t> active;      ///< slots; what is awake and in range, then what was woken
    std::vector<std::uint32_t> placed;      ///< slots with a place
    std::vector<SolverBody> solver_bodies;  ///< by place: the active bodies', and of what they touch
    std::vector<SolverPair> pairs, island_pairs;
    std::vector<Contact> contacts, found;
    std::vector<std::uint32_t> near, parent, island, members;
    std::vector<std::uint32_t> body_begin, body_order, pair_begin, pair_order;
    std::vector<Push> pushes;

    Character* find(CharacterId id);
    Status give_shapes(Character& character);
    /// Makes the lists of slots anew, from the bodies.
    void list_bodies();
    void wake(std::uint32_t slot);
    void fall_asleep(std::uint32_t slot);
    /// Counts a body that sleeps among the sleepers, or no longer.
    void count_asleep(std::uint32_t slot, bool sleeps);
    [[nodiscard]] std::uint64_t hash_of(std::uint32_t slot) const;
    /// Wakes what sleeps near a box.
    void wake_near(const DBox3& box);

    // The step, in order.
    void move_kinematic();
    void move_characters(StepStats& stats);
    void choose_active(std::span<const WorldPos> viewers, StepStats& stats);
    void find_contacts(StepStats& stats);
    void solve_islands(StepStats& stats);
    void touch_bodies(std::uint32_t slot, std::uint32_t place);
    void touch_characters(std::uint32_t slot, std::uint32_t place);
    void integrate(std::uint32_t slot);
    void let_sleep();

    std::uint32_t place_of(std::uint32_t slot);
    void activate(std::uint32_t slot);
    /// Takes what was found; `friction`, `restitution` and `rolling_m` as in SolverPair.
    void add_pair(const SolverPair& pair);
};

[[nodiscard]] inline Vec3 inertia_of(const Body& body) {
    return body.geometry->inertia_per_kg * body.desc.mass_kg;
}
/// Errors: what BodyDesc does not allow, its shape apart. Makes the rotation unit.
Status check_body(BodyDesc& desc);
Status check_character(const CharacterDesc& desc);
Status check_input(const CharacterInput& input);

}  // namespace ff::physics
