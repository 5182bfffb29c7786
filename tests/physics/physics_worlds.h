#pragma once
// Grounds to walk and fall on, in a line each. Everything may be moved far from the world's origin.

#include <vector>

#include "engine/physics/physics_world.h"
#include "tests/support/worlds.h"

namespace ff::test {

/// One mesh of opaque triangles, put together part by part.
class Ground {
  public:
    Ground& box(const Vec3& low, const Vec3& high, int quads = 1) {
        append_box(mesh_, low, high, quads, 0);
        return *this;
    }
    /// A level square around (0, 0), of quads of 1 m: many inner edges.
    Ground& floor(float half_size, float y = 0.0f);
    /// A plane that rises along +x from x = 0 by `slope_deg`, `length` metres along the slope, 20 m wide.
    Ground& ramp(double slope_deg, float length);
    /// Stairs up along +x from x = 0, 6 m wide.
    Ground& stairs(int steps, float rise, float run);
    Ground& triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
        append_triangle(mesh_, a, b, c, 0);
        return *this;
    }
    [[nodiscard]] scene::SceneData finish(const WorldPos& origin = WorldPos(0.0)) const;

  private:
    scene::MeshSource mesh_;
};

/// Keeps what a PhysicsWorld borrows.
struct Walled {
    explicit Walled(scene::SceneData given, const physics::PhysicsSettings& settings = {})
        : data(std::move(given)), view(data.view()), world(view, settings) {}
    scene::SceneData data;
    scene::StaticScene view;
    physics::PhysicsWorld world;

    physics::CharacterId walker(const WorldPos& feet) { return *world.add_character({.position = feet}); }
    void walk(physics::CharacterId id, const Vec3& velocity, int ticks) {
        (void)bool(world.set_input(id, {.velocity_m_s = velocity}));
        for (int i = 0; i < ticks; ++i) world.step();
    }
};

}  // namespace ff::test
