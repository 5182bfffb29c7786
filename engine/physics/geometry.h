#pragma once
// What a body's shape is made of, once and for all bodies of that shape: for Bullet, and for our own sweeps.

#include <memory>
#include <vector>

#include "engine/core/result.h"
#include "engine/math/bounds.h"
#include "engine/physics/capsule.h"
#include "engine/physics/types.h"
#include "engine/scene/static_scene.h"

class btConvexShape;

namespace ff::physics {

/// Bullet's header is known to geometry.cpp alone.
struct DeleteBulletShape {
    void operator()(btConvexShape* shape) const;
};

/// All in the frame of the centre of mass, axes as the body's. Immutable.
struct Geometry {
    Geometry();
    ~Geometry();

    Shape shape;
    DVec3 center_of_mass{0.0};                                 ///< in the body's frame
    std::unique_ptr<btConvexShape, DeleteBulletShape> bullet;  ///< null for a mesh
    Segment core;                                              ///< sphere, capsule
    double radius_m = 0.0;                                     ///< of those; 0 for the others
    std::vector<Triangle> faces;                               ///< box, hull: outward
    std::vector<DVec3> normals;                                ///< of the faces, unit
    DBox3 bounds;
    double inner_radius_m = 0.0;  ///< of a ball around the centre of mass that is inside; 0 for a mesh
    Vec3 inertia_per_kg{1.0f};    ///< m^2, about the axes; a hull's is that of the box around it

    [[nodiscard]] bool is_round() const { return radius_m > 0.0; }
};

/// Errors (usage): numbers out of the ranges of types.h, no such mesh, a hull without a volume.
Result<std::shared_ptr<const Geometry>> make_geometry(const scene::StaticScene& scene, const Shape& shape);

/// What a shape says is equal.
[[nodiscard]] bool is_same(const Shape& a, const Shape& b);

}  // namespace ff::physics
