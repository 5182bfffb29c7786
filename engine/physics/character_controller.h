#pragma once
// One tick of a character: carried by what it stands on, pushed out of what moved into it, then walked or let fall.
//
// Every move is a sweep of the capsule, so nothing is too fast. What is hit turns the rest of the move aside:
//
//   slide       along the surface, along the crease of two, and nowhere in a corner of three
//   step        where a wall stops a walk: up, ahead, and down again onto something that can be walked
//   follow      down to the ground that a walk leaves, as far as a step is high
//
// A surface can be walked by what it is, not by where the round foot touches it: on the edge of a stair the capsule's
// normal leans, but the tread is flat.

#include <vector>

#include "engine/physics/character.h"
#include "engine/physics/obstacles.h"

namespace ff::physics {

struct Character {
    CharacterDesc desc;
    CharacterInput input;
    std::uint32_t generation = 0;
    bool alive = false;
    DVec3 feet{0.0};
    DVec3 velocity{0.0};  ///< of its own; what carries it comes on top
    DVec3 ground_normal{0.0, 1.0, 0.0};
    BodyId ground;
    bool on_ground = false;
    bool crouching = false;

    // Derived.
    std::shared_ptr<const Geometry> standing, crouched;
    DVec3 ridden{0.0};        ///< in the step that goes on
    std::int32_t place = -1;  ///< in the lists of that step

    [[nodiscard]] double height() const { return double(crouching ? desc.crouch_height_m : desc.height_m); }
    [[nodiscard]] Segment capsule(const DVec3& at) const {
        const double r = desc.radius_m;
        return {at + DVec3(0.0, r, 0.0), at + DVec3(0.0, height() - r, 0.0)};
    }
};

/// What a character did to a dynamic body.
struct Push {
    BodyId body;
    Vec3 impulse_n_s{0.0f};
    DVec3 at{0.0};
};

class CharacterController {
  public:
    CharacterController(const scene::StaticScene& scene, const BodyStore& bodies)
        : bodies_(bodies), query_(scene, bodies, slots_) {}
    CharacterController(const CharacterController&) = delete;
    CharacterController& operator=(const CharacterController&) = delete;

    /// @param pushes  appended
    void move(Character& character, double tick_s, std::vector<Push>& pushes);

    [[nodiscard]] ObstacleQuery& query() { return query_; }

  private:
    struct Ground {
        bool found = false;
        DVec3 normal{0.0, 1.0, 0.0};
        BodyId body;
        DVec3 point{0.0};
    };
    struct Slide {
        DVec3 feet{0.0};
        bool hit = false;
    };
    void crouch_or_rise(Character& c);
    void ride(Character& c, double tick_s);
    void recover(Character& c);
    void walk(Character& c, const DVec3& along, double tick_s);
    void fall(Character& c, double tick_s);
    [[nodiscard]] Slide slide(const Character& c, DVec3 feet, DVec3 along, bool walking);
    [[nodiscard]] bool step_up(const Character& c, const DVec3& along, const DVec3& reached, DVec3& feet);
    [[nodiscard]] Ground follow_down(const Character& c, double depth, DVec3& feet);
    [[nodiscard]] Ground ground_at(const Character& c, const DVec3& feet);
    void push_bodies(const Character& c, const DVec3& wished, double tick_s, std::vector<Push>& pushes);

    const BodyStore& bodies_;
    std::vector<std::uint32_t> slots_;  // scratch of query_
    ObstacleQuery query_;
    std::vector<Obstacle> near_;  // scratch
    std::vector<Obstacle> met_;   // dynamic bodies that this tick's slides hit
};

}  // namespace ff::physics
