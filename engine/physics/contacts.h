#pragma once
// Where two bodies, or a body and the triangles around it, touch: found anew each tick, so that a tick depends on
// nothing but where things are.
//
// Based on: Coumans, Bullet Physics 3.24 (GJK, EPA, clipping of faces); Terdiman, "Contact generation for meshes",
// codercorner.com 2012 (face contacts first, edges that a face covers dropped). Ours differs: a triangle pushes along
// its own face wherever a body is not deep in it, so that the inner edges of a floor catch nothing.

#include <memory>
#include <span>
#include <vector>

#include "engine/physics/body_store.h"

namespace ff::physics {

/// One contact of bodies A and B; vectors in world axes.
struct Contact {
    Vec3 from_a{0.0f};   ///< point on A, from A's centre of mass
    Vec3 from_b{0.0f};   ///< point on B, from B's; from A's where B is the static scene
    Vec3 normal{0.0f};   ///< unit, from B to A
    float distance = 0;  ///< negative: depth
};

/// Contacts count up to this distance, metres: the solver keeps the gap from closing within the tick.
inline constexpr double kContactReach_m = 0.02;

class ContactFinder {
  public:
    explicit ContactFinder(const scene::StaticScene& scene);
    ~ContactFinder();

    /// A body against the static scene. Replaces `out`.
    void with_scene(const Geometry& a, const Frame& frame, const DBox3& bounds, std::vector<Contact>& out);
    /// Two bodies; at most one of shape mesh, and that is B. Replaces `out`.
    void between(const Geometry& a, const Frame& frame_a, const DBox3& bounds_a, const Geometry& b,
                 const Frame& frame_b, std::vector<Contact>& out);

    [[nodiscard]] std::uint64_t triangles_tested() const { return triangles_tested_; }
    void reset_count() { triangles_tested_ = 0; }

  private:
    struct Gjk;
    void gather(const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf, const DBox3& box,
                const DVec3& origin);
    void with_triangles(const Geometry& a, const Frame& frame, std::vector<Contact>& out);
    void round_with_triangle(const Geometry& a, const DMat3& turn, const Triangle& triangle, bool& face);
    void hull_with_triangle(const Geometry& a, const DMat3& turn, const Triangle& triangle, bool& face);
    void round_with_hull(const Geometry& a, const Frame& frame_a, const Geometry& b, const Frame& frame_b, bool flip,
                         std::vector<Contact>& out) const;
    void hulls(const Geometry& a, const Frame& frame_a, const Geometry& b, const Frame& frame_b,
               std::vector<Contact>& out);

    struct EdgeContact {
        Contact contact;
        DVec3 point;  ///< on the triangle
    };
    const scene::StaticScene& scene_;
    std::unique_ptr<Gjk> gjk_;
    std::vector<Triangle> triangles_;  // scratch: relative to A's centre of mass, world axes
    std::vector<Triangle> faces_;      // those that pushed along their faces
    std::vector<Contact> found_;
    std::vector<EdgeContact> edges_;
    std::uint64_t triangles_tested_ = 0;
};

}  // namespace ff::physics
