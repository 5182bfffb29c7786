#include "engine/physics/contacts.h"

#include <BulletCollision/CollisionShapes/btConvexPolyhedron.h>
#include <BulletCollision/CollisionShapes/btPolyhedralConvexShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btPolyhedralContactClipping.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/physics/hull_distance.h"

namespace ff::physics {
namespace {

btVector3 to_bullet(const DVec3& v) {
    return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}
DVec3 from_bullet(const btVector3& v) {
    return {double(v.x()), double(v.y()), double(v.z())};
}
btTransform to_bullet(const DMat3& turn, const DVec3& position) {
    const DMat3& m = turn;
    return btTransform(
        btMatrix3x3(btScalar(m[0].x), btScalar(m[1].x), btScalar(m[2].x), btScalar(m[0].y), btScalar(m[1].y),
                    btScalar(m[2].y), btScalar(m[0].z), btScalar(m[1].z), btScalar(m[2].z)),
        to_bullet(position));
}

/// What Bullet's clipping finds, relative to A's centre of mass; points are on B.
struct ClipResult final : btDiscreteCollisionDetectorInterface::Result {
    std::vector<Contact>* out = nullptr;
    DVec3 b_from_a{0.0};

    void setShapeIdentifiersA(int, int) override {}
    void setShapeIdentifiersB(int, int) override {}
    void addContactPoint(const btVector3& normal, const btVector3& point, btScalar depth) override {
        const DVec3 n = from_bullet(normal), p = from_bullet(point);
        out->push_back({Vec3(p + n * double(depth)), Vec3(p - b_from_a), Vec3(n), float(depth)});
    }
};

}  // namespace

/// Bullet's searches and their buffers, kept from call to call; none of them remembers anything between.
struct ContactFinder::Gjk {
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver epa;
    btTriangleShape triangle;
    btVertexArray vertices_1, vertices_2;

    Gjk() { triangle.setMargin(0.0f); }

    /// Nearest points, or the way out; nothing where the gap is more than `reach`.
    bool closest(const btConvexShape& a, const btTransform& at_a, const btConvexShape& b, const btTransform& at_b,
                 double reach, btPointCollector& out) {
        btGjkPairDetector detector(&a, &b, &simplex, &epa);
        btGjkPairDetector::ClosestPointInput input;
        input.m_transformA = at_a;
        input.m_transformB = at_b;
        const btScalar far = a.getMargin() + b.getMargin() + btScalar(reach);
        input.m_maximumDistanceSquared = far * far;
        detector.getClosestPoints(input, out, nullptr);
        return out.m_hasResult && double(out.m_distance) <= reach;
    }
};

ContactFinder::ContactFinder(const scene::StaticScene& scene) : scene_(scene), gjk_(std::make_unique<Gjk>()) {}
ContactFinder::~ContactFinder() = default;

void ContactFinder::gather(const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf, const DBox3& box,
                           const DVec3& origin) {
    const DVec3 offset = at.position - origin;
    for (int i = 0; i < leaf.triangle_count; ++i) {
        const Triangle t{offset + at.world_from_mesh * leaf_corner(leaf, i, 0),
                         offset + at.world_from_mesh * leaf_corner(leaf, i, 1),
                         offset + at.world_from_mesh * leaf_corner(leaf, i, 2)};
        const DVec3 low = glm::min(t.a, glm::min(t.b, t.c)), high = glm::max(t.a, glm::max(t.b, t.c));
        if (low.x > box.high.x || low.y > box.high.y || low.z > box.high.z || high.x < box.low.x ||
            high.y < box.low.y || high.z < box.low.z)
            continue;
        if (is_solid(scene_, mesh, leaf, i)) triangles_.push_back(t);
    }
}

void ContactFinder::with_scene(const Geometry& a, const Frame& frame, const DBox3& bounds, std::vector<Contact>& out) {
    triangles_.clear();
    const DVec3 reach(kContactReach_m);
    const DBox3 box{bounds.low - frame.position - reach, bounds.high - frame.position + reach};
    const SweptBox swept{bounds.center(), DVec3(0.0), bounds.extent() * 0.5 + reach};
    walk_scene(
        scene_, swept, [] { return 1.0f; },
        [&](const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf) {
            gather(at, mesh, leaf, box, frame.position);
        });
    with_triangles(a, frame, out);
}

void ContactFinder::with_triangles(const Geometry& a, const Frame& frame, std::vector<Contact>& out) {
    out.clear();
    found_.clear();
    faces_.clear();
    edges_.clear();
    const DMat3 turn = matrix_of(frame.rotation);
    for (const Triangle& triangle : triangles_) {
        ++triangles_tested_;
        bool face = false;
        if (a.is_round())
            round_with_triangle(a, turn, triangle, face);
        else
            hull_with_triangle(a, turn, triangle, face);
        if (face) faces_.push_back(triangle);
    }
    out.insert(out.end(), found_.begin(), found_.end());
    // An edge that lies in a face which pushes already is the inside of a surface.
    constexpr double kCovered_m = 0.005;
    for (const EdgeContact& edge : edges_) {
        const bool covered = std::any_of(faces_.begin(), faces_.end(), [&](const Triangle& face) {
            return glm::length(nearest_on_triangle(face, edge.point) - edge.point) < kCovered_m;
        });
        if (!covered) out.push_back(edge.contact);
    }
}

void ContactFinder::round_with_triangle(const Geometry& a, const DMat3& turn, const Triangle& triangle, bool& face) {
    const Segment core{turn * a.core.a, turn * a.core.b};
    DVec3 up = normal_of(triangle);
    if (glm::dot(up, -triangle.a) < 0.0) up = -up;
    const auto take = [&](const DVec3& on_core, const DVec3& on_triangle, double distance) {
        if (distance > a.radius_m + kContactReach_m) return;
        const DVec3 normal = distance > 1e-9 ? (on_core - on_triangle) / distance : up;
        if (normal == DVec3(0.0)) return;
        const Contact contact{Vec3(on_core - normal * a.radius_m), Vec3(on_triangle), Vec3(normal),
                              float(distance - a.radius_m)};
        if (glm::dot(normal, up) > 0.999) {
            face = true;
            found_.push_back(contact);
        } else {
            edges_.push_back({contact, on_triangle});
        }
    };
    const Nearest n = nearest(core, triangle);
    take(n.on_segment, n.on_other, n.distance);
    if (a.core.a == a.core.b) return;
    // The ends, too: a capsule that lies on its side would roll over a single point.
    for (const DVec3& end : {core.a, core.b}) {
        if (end == n.on_segment) continue;
        const DVec3 q = nearest_on_triangle(triangle, end);
        const double distance = glm::length(end - q);
        if (distance > 1e-9 && glm::dot((end - q) / distance, up) > 0.999) take(end, q, distance);
    }
}

void ContactFinder::hull_with_triangle(const Geometry& a, const DMat3& turn, const Triangle& triangle, bool& face) {
    // Parted by the box around the hull?
    const DVec3 corner[3] = {triangle.a * turn, triangle.b * turn, triangle.c * turn};
    for (int axis = 0; axis < 3; ++axis) {
        const double low = std::min({corner[0][axis], corner[1][axis], corner[2][axis]});
        const double high = std::max({corner[0][axis], corner[1][axis], corner[2][axis]});
        if (low > a.bounds.high[axis] + kContactReach_m || high < a.bounds.low[axis] - kContactReach_m) return;
    }
    // Parted by the triangle's plane?
    DVec3 up = normal_of(triangle);
    if (up == DVec3(0.0)) return;
    if (glm::dot(up, -triangle.a) < 0.0) up = -up;
    const auto& hull = static_cast<const btPolyhedralConvexShape&>(*a.bullet);
    const btConvexPolyhedron& polyhedron = *hull.getConvexPolyhedron();
    const DVec3 local_up = up * turn;
    double lowest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < polyhedron.m_vertices.size(); ++i)
        lowest = std::min(lowest, glm::dot(local_up, from_bullet(polyhedron.m_vertices[i])));
    const double gap = lowest - glm::dot(up, triangle.a);
    if (gap > kContactReach_m) return;

    const btTransform at = to_bullet(turn, DVec3(0.0));
    ClipResult clip;
    const auto clip_along = [&](const btVector3& normal, double deepest) {
        gjk_->vertices_1.resizeNoInitialize(0);
        gjk_->vertices_2.resizeNoInitialize(0);
        for (const DVec3& p : {triangle.a, triangle.b, triangle.c}) gjk_->vertices_1.push_back(to_bullet(p));
        btPolyhedralContactClipping::clipFaceAgainstHull(normal, polyhedron, at, gjk_->vertices_1, gjk_->vertices_2,
                                                         btScalar(deepest), btScalar(kContactReach_m), clip);
    };
    // Not deep: the face pushes. What is deeper may have come over an edge, and leaves by the shortest way.
    if (gap > -0.25 * a.inner_radius_m) {
        const std::size_t before = found_.size();
        clip.out = &found_;
        clip_along(to_bullet(up), gap - 0.005);
        face = found_.size() > before;
        return;
    }
    gjk_->triangle.m_vertices1[0] = to_bullet(triangle.a);
    gjk_->triangle.m_vertices1[1] = to_bullet(triangle.b);
    gjk_->triangle.m_vertices1[2] = to_bullet(triangle.c);
    btPointCollector closest;
    if (!gjk_->closest(hull, at, gjk_->triangle, btTransform::getIdentity(), kContactReach_m, closest)) return;
    std::vector<Contact>& points = found_;
    const std::size_t before = points.size();
    clip.out = &points;
    clip_along(closest.m_normalOnBInWorld, double(closest.m_distance) - 0.005);
    // An edge against a face leaves nothing to clip: the nearest points are the contact.
    if (points.size() == before)
        clip.addContactPoint(closest.m_normalOnBInWorld, closest.m_pointInWorld, closest.m_distance);
    for (std::size_t i = before; i < points.size(); ++i) edges_.push_back({points[i], DVec3(points[i].from_b)});
    points.resize(before);
}

void ContactFinder::between(const Geometry& a, const Frame& frame_a, const DBox3& bounds_a, const Geometry& b,
                            const Frame& frame_b, std::vector<Contact>& out) {
    out.clear();
    if (b.shape.kind == ShapeKind::mesh) {
        triangles_.clear();
        const DVec3 reach(kContactReach_m);
        const DBox3 box{bounds_a.low - frame_a.position - reach, bounds_a.high - frame_a.position + reach};
        const SweptBox swept{bounds_a.center(), DVec3(0.0), bounds_a.extent() * 0.5 + reach};
        const PlacedMesh at = placed(b, frame_b);
        walk_mesh(
            scene_, at, swept, [] { return 1.0f; },
            [&](const scene::Mesh& mesh, const scene::BvhLeaf& leaf) {
                gather(at, mesh, leaf, box, frame_a.position);
            });
        with_triangles(a, frame_a, out);
        const Vec3 b_from_a(frame_b.position - frame_a.position);
        for (Contact& contact : out) contact.from_b -= b_from_a;
        return;
    }
    if (a.is_round() && b.is_round()) {
        const DVec3 b_from_a = frame_b.position - frame_a.position;
        const DMat3 turn_a = matrix_of(frame_a.rotation), turn_b = matrix_of(frame_b.rotation);
        const Segment core_a{turn_a * a.core.a, turn_a * a.core.b};
        const Segment core_b{b_from_a + turn_b * b.core.a, b_from_a + turn_b * b.core.b};
        const double radius = a.radius_m + b.radius_m;
        const auto take = [&](const DVec3& on_a, const DVec3& on_b) {
            const double distance = glm::length(on_a - on_b);
            if (distance > radius + kContactReach_m) return;
            const DVec3 normal = distance > 1e-9 ? (on_a - on_b) / distance : DVec3(0.0, 1.0, 0.0);
            out.push_back({Vec3(on_a - normal * a.radius_m), Vec3(on_b + normal * b.radius_m - b_from_a), Vec3(normal),
                           float(distance - radius)});
        };
        const Nearest n = nearest(core_a, core_b);
        take(n.on_segment, n.on_other);
        // Side by side they touch along a line: both ends of it.
        for (const DVec3& end : {core_a.a, core_a.b})
            if (core_a.a != core_a.b && end != n.on_segment) {
                const DVec3 q = nearest_on_segment(core_b, end);
                if (glm::length(end - q) < n.distance + 0.01) take(end, q);
            }
        return;
    }
    if (a.is_round())
        round_with_hull(a, frame_a, b, frame_b, false, out);
    else if (b.is_round())
        round_with_hull(b, frame_b, a, frame_a, true, out);
    else
        hulls(a, frame_a, b, frame_b, out);
}

void ContactFinder::round_with_hull(const Geometry& a, const Frame& frame_a, const Geometry& b, const Frame& frame_b,
                                    bool flip, std::vector<Contact>& out) const {
    const DMat3 turn_a = matrix_of(frame_a.rotation), turn_b = matrix_of(frame_b.rotation);
    const DVec3 a_from_b = frame_a.position - frame_b.position;
    const Segment core{(a_from_b + turn_a * a.core.a) * turn_b, (a_from_b + turn_a * a.core.b) * turn_b};
    const auto take = [&](const Segment& part) {
        const auto n = nearest_on_hull(part, a.radius_m + kContactReach_m, b);
        if (!n) return;
        const DVec3 normal = turn_b * n->normal;
        const DVec3 on_b = turn_b * n->on_hull;
        const DVec3 on_a = turn_b * n->on_segment - a_from_b - normal * a.radius_m;
        const float distance = float(n->distance - a.radius_m);
        if (flip)
            out.push_back({Vec3(on_b), Vec3(on_a), Vec3(-normal), distance});
        else
            out.push_back({Vec3(on_a), Vec3(on_b), Vec3(normal), distance});
    };
    take(core);
    if (a.core.a == a.core.b) return;
    take({core.a, core.a});
    take({core.b, core.b});
}

void ContactFinder::hulls(const Geometry& a, const Frame& frame_a, const Geometry& b, const Frame& frame_b,
                          std::vector<Contact>& out) {
    const DVec3 b_from_a = frame_b.position - frame_a.position;
    const btTransform at_a = to_bullet(matrix_of(frame_a.rotation), DVec3(0.0));
    const btTransform at_b = to_bullet(matrix_of(frame_b.rotation), b_from_a);
    btPointCollector closest;
    if (!gjk_->closest(*a.bullet, at_a, *b.bullet, at_b, kContactReach_m, closest)) return;
    ClipResult clip;
    clip.out = &out;
    clip.b_from_a = b_from_a;
    gjk_->vertices_1.resizeNoInitialize(0);
    gjk_->vertices_2.resizeNoInitialize(0);
    btPolyhedralContactClipping::clipHullAgainstHull(
        closest.m_normalOnBInWorld, *static_cast<const btPolyhedralConvexShape&>(*a.bullet).getConvexPolyhedron(),
        *static_cast<const btPolyhedralConvexShape&>(*b.bullet).getConvexPolyhedron(), at_a, at_b,
        closest.m_distance - 0.005f, btScalar(kContactReach_m), gjk_->vertices_1, gjk_->vertices_2, clip);
    if (out.empty()) clip.addContactPoint(closest.m_normalOnBInWorld, closest.m_pointInWorld, closest.m_distance);
}

}  // namespace ff::physics
