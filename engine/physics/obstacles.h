#pragma once
// What stands in the way of a capsule or a ray: the static scene and the bodies, asked alike.

#include <optional>
#include <vector>

#include "engine/physics/body_store.h"
#include "engine/physics/capsule.h"

namespace ff::physics {

/// A surface that a capsule touches.
struct Obstacle {
    DVec3 normal{0.0};  ///< unit, towards the capsule
    DVec3 point{0.0};
    double gap = 0.0;    ///< from the capsule's surface; negative: how deep it is in
    double time = 0.0;   ///< of a sweep, [0, 1]
    double face_up = 0;  ///< y of the unit normal of the touched face, on the capsule's side
    BodyId body;         ///< null: the static scene
    std::uint32_t instance = 0, triangle = 0;
};

/// What it looks at may be looked at by many; its scratch belongs to one thread.
class ObstacleQuery {
  public:
    /// @param slots  scratch, borrowed: one for each thread
    ObstacleQuery(const scene::StaticScene& scene, const BodyStore& bodies, std::vector<std::uint32_t>& slots)
        : scene_(scene), bodies_(bodies), slots_(slots) {}

    /// The first that a moving capsule meets and comes nearer to; ties go to the scene, then to the lower slot.
    /// @param leave_crossed  see touch()
    [[nodiscard]] std::optional<Obstacle> sweep(const Segment& capsule, double radius, const DVec3& along,
                                                const QueryFilter& filter, bool leave_crossed = false);
    /// All within `reach` of the capsule's surface, the scene's first; replaces what `out` holds.
    void near(const Segment& capsule, double radius, double reach, const QueryFilter& filter,
              std::vector<Obstacle>& out);
    /// The first surface on the way, from either side.
    [[nodiscard]] std::optional<Obstacle> ray(const DVec3& from, const DVec3& along, const QueryFilter& filter);

    [[nodiscard]] std::uint64_t triangles_tested() const { return triangles_tested_; }
    void reset_count() { triangles_tested_ = 0; }

  private:
    const scene::StaticScene& scene_;
    const BodyStore& bodies_;
    std::vector<std::uint32_t>& slots_;
    std::uint64_t triangles_tested_ = 0;
};

}  // namespace ff::physics
