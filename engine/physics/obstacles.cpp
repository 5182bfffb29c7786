#include "engine/physics/obstacles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/physics/hull_distance.h"

namespace ff::physics {
namespace {

SweptBox swept_box(const Segment& s, double reach, const DVec3& along) {
    return {(s.a + s.b) * 0.5, along, glm::abs(s.b - s.a) * 0.5 + DVec3(reach)};
}

/// A body's own frame: its faces stay as they are, and the capsule comes to them.
struct LocalFrame {
    DMat3 world_from_body;
    DVec3 position;

    explicit LocalFrame(const Frame& frame) : world_from_body(matrix_of(frame.rotation)), position(frame.position) {}
    [[nodiscard]] DVec3 vector(const DVec3& v) const { return v * world_from_body; }  // the transpose times v
    [[nodiscard]] DVec3 point(const DVec3& p) const { return vector(p - position); }
    [[nodiscard]] Segment segment(const Segment& s) const { return {point(s.a), point(s.b)}; }
    [[nodiscard]] DVec3 world_vector(const DVec3& v) const { return world_from_body * v; }
    [[nodiscard]] DVec3 world_point(const DVec3& p) const { return position + world_vector(p); }
};

Triangle triangle_of(const PlacedMesh& at, const scene::BvhLeaf& leaf, int i) {
    return {at.position + at.world_from_mesh * leaf_corner(leaf, i, 0),
            at.position + at.world_from_mesh * leaf_corner(leaf, i, 1),
            at.position + at.world_from_mesh * leaf_corner(leaf, i, 2)};
}

/// Whether a triangle's box is within reach of the segment moved along: most of a leaf's are not.
bool may_touch(const Triangle& t, const SweptBox& box) {
    DBox3 bounds;
    bounds.low = glm::min(t.a, glm::min(t.b, t.c)) - box.half;
    bounds.high = glm::max(t.a, glm::max(t.b, t.c)) + box.half;
    return meets_segment(bounds, box.from, box.along);
}

double face_up(const DVec3& face, const DVec3& towards) {
    return glm::dot(face, towards) >= 0.0 ? face.y : -face.y;
}

/// How deep a segment is behind a plane through `point`, and on which side most of it is.
Obstacle crossed(const Segment& s, double radius, DVec3 normal, const DVec3& point) {
    if (normal == DVec3(0.0)) normal = DVec3(0.0, 1.0, 0.0);
    if (glm::dot(normal, (s.a + s.b) * 0.5 - point) < 0.0) normal = -normal;
    Obstacle out;
    out.normal = normal;
    out.point = point;
    out.gap = std::min(glm::dot(normal, s.a - point), glm::dot(normal, s.b - point)) - radius;
    return out;
}

/// y of the face that a point of a convex body lies on and that looks up most, in the world.
double best_face_up(const Geometry& geometry, const LocalFrame& frame, const DVec3& local_point) {
    double best = -1.0;
    for (std::size_t f = 0; f < geometry.faces.size(); ++f)
        if (std::abs(glm::dot(geometry.normals[f], local_point - geometry.faces[f].a)) < 1e-4)
            best = std::max(best, frame.world_vector(geometry.normals[f]).y);
    return best;
}

}  // namespace

std::optional<Obstacle> ObstacleQuery::sweep(const Segment& capsule, double radius, const DVec3& along,
                                             const QueryFilter& filter, bool leave_crossed) {
    const SweptBox box = swept_box(capsule, radius, along);
    double limit = 1.0;
    std::optional<Obstacle> first;
    const auto take = [&](const Touch& t, double up, BodyId body, std::uint32_t instance, std::uint32_t triangle) {
        // At the same moment the one that is met most squarely: a floor's face, not the edge of its neighbour.
        if (first && t.time == first->time && glm::dot(t.normal, along) >= glm::dot(first->normal, along)) return;
        first = Obstacle{t.normal, t.point, 0.0, t.time, up, body, instance, triangle};
        limit = t.time;
    };
    const auto mesh_leaf = [&](const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf, BodyId body) {
        for (int i = 0; i < leaf.triangle_count; ++i) {
            const Triangle t = triangle_of(at, leaf, i);
            if (!may_touch(t, box) || !is_solid(scene_, mesh, leaf, i)) continue;
            ++triangles_tested_;
            if (const auto found = touch(capsule, radius, along, t, limit, leave_crossed))
                take(*found, face_up(normal_of(t), found->normal), body, at.instance,
                     leaf.first_triangle + std::uint32_t(i));
        }
    };
    const auto limit_f = [&] { return float(limit); };
    if (filter.static_scene)
        walk_scene(scene_, box, limit_f,
                   [&](const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf) {
                       mesh_leaf(at, mesh, leaf, {});
                   });
    if (!filter.bodies) return first;
    bodies_.find(box, slots_);
    for (const std::uint32_t slot : slots_) {
        const BodyId id = bodies_.id_of(slot);
        if (id == filter.except) continue;
        const Body& body = bodies_[slot];
        const Geometry& geometry = *body.geometry;
        if (geometry.shape.kind == ShapeKind::mesh) {
            const PlacedMesh at = placed(geometry, body.frame);
            walk_mesh(scene_, at, box, limit_f,
                      [&](const scene::Mesh& mesh, const scene::BvhLeaf& leaf) { mesh_leaf(at, mesh, leaf, id); });
            continue;
        }
        const LocalFrame frame(body.frame);
        const Segment local = frame.segment(capsule);
        const DVec3 local_along = frame.vector(along);
        const auto found_at = [&](const Touch& t, double up) {
            take({t.time, frame.world_vector(t.normal), frame.world_point(t.point)}, up, id, 0, 0);
        };
        if (geometry.is_round()) {
            if (auto found =
                    touch(local, radius + geometry.radius_m, local_along, geometry.core, limit, leave_crossed)) {
                found->point += found->normal * geometry.radius_m;
                found_at(*found, frame.world_vector(found->normal).y);
            }
            continue;
        }
        // A capsule that begins within a body is not held there: only faces that it goes into count.
        for (std::size_t f = 0; f < geometry.faces.size(); ++f) {
            if (glm::dot(geometry.normals[f], local_along) >= 0.0) continue;
            ++triangles_tested_;
            if (const auto found = touch(local, radius, local_along, geometry.faces[f], limit, leave_crossed))
                found_at(*found, best_face_up(geometry, frame, found->point));
        }
    }
    return first;
}

void ObstacleQuery::near(const Segment& capsule, double radius, double reach, const QueryFilter& filter,
                         std::vector<Obstacle>& out) {
    out.clear();
    const SweptBox box = swept_box(capsule, radius + reach, DVec3(0.0));
    const auto limit = [] { return 1.0f; };
    const auto mesh_leaf = [&](const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf, BodyId body) {
        for (int i = 0; i < leaf.triangle_count; ++i) {
            const Triangle t = triangle_of(at, leaf, i);
            if (!may_touch(t, box) || !is_solid(scene_, mesh, leaf, i)) continue;
            ++triangles_tested_;
            const Nearest found = nearest(capsule, t);
            if (found.distance > radius + reach) continue;
            const DVec3 face = normal_of(t);
            Obstacle obstacle;
            if (found.distance > 1e-12) {
                obstacle.normal = (found.on_segment - found.on_other) / found.distance;
                obstacle.point = found.on_other;
                obstacle.gap = found.distance - radius;
            } else {
                obstacle = crossed(capsule, radius, face, found.on_other);
            }
            obstacle.face_up = face_up(face, obstacle.normal);
            obstacle.body = body;
            obstacle.instance = at.instance;
            obstacle.triangle = leaf.first_triangle + std::uint32_t(i);
            out.push_back(obstacle);
        }
    };
    if (filter.static_scene)
        walk_scene(scene_, box, limit, [&](const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf) {
            mesh_leaf(at, mesh, leaf, {});
        });
    if (!filter.bodies) return;
    bodies_.find(box, slots_);
    for (const std::uint32_t slot : slots_) {
        const BodyId id = bodies_.id_of(slot);
        if (id == filter.except) continue;
        const Body& body = bodies_[slot];
        const Geometry& geometry = *body.geometry;
        if (geometry.shape.kind == ShapeKind::mesh) {
            const PlacedMesh at = placed(geometry, body.frame);
            walk_mesh(scene_, at, box, limit,
                      [&](const scene::Mesh& mesh, const scene::BvhLeaf& leaf) { mesh_leaf(at, mesh, leaf, id); });
            continue;
        }
        const LocalFrame frame(body.frame);
        const Segment local = frame.segment(capsule);
        std::optional<Obstacle> found;
        if (geometry.is_round()) {
            const Nearest n = nearest(local, geometry.core);
            if (n.distance > radius + geometry.radius_m + reach) continue;
            found.emplace();
            found->normal = n.distance > 1e-12 ? (n.on_segment - n.on_other) / n.distance : frame.vector({0, 1, 0});
            found->point = n.on_other + found->normal * geometry.radius_m;
            found->gap = n.distance - radius - geometry.radius_m;
            found->face_up = frame.world_vector(found->normal).y;
        } else {
            const auto n = nearest_on_hull(local, radius + reach, geometry);
            if (!n) continue;
            found.emplace();
            found->normal = n->normal;
            found->point = n->on_hull;
            found->gap = n->distance - radius;
            found->face_up = best_face_up(geometry, frame, found->point);
        }
        found->normal = frame.world_vector(found->normal);
        found->point = frame.world_point(found->point);
        found->body = id;
        out.push_back(*found);
    }
}

std::optional<Obstacle> ObstacleQuery::ray(const DVec3& from, const DVec3& along, const QueryFilter& filter) {
    const SweptBox box{from, along, DVec3(0.0)};
    double limit = 1.0;
    std::optional<Obstacle> first;
    // Moeller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 1997, relative to the ray's start.
    const auto triangle = [&](const Triangle& t, BodyId body, std::uint32_t instance, std::uint32_t id) {
        ++triangles_tested_;
        const DVec3 ab = t.b - t.a, ac = t.c - t.a, to = from - t.a;
        const DVec3 p = glm::cross(along, ac);
        const double det = glm::dot(ab, p);
        if (det == 0.0) return;
        const double u = glm::dot(to, p) / det;
        if (!(u >= 0.0 && u <= 1.0)) return;
        const DVec3 q = glm::cross(to, ab);
        const double v = glm::dot(along, q) / det;
        if (!(v >= 0.0 && u + v <= 1.0)) return;
        const double time = glm::dot(ac, q) / det;
        if (!(time >= 0.0 && time <= limit) || (first && time == limit)) return;
        DVec3 normal = normal_of(t);
        if (glm::dot(normal, along) > 0.0) normal = -normal;
        first = Obstacle{normal, from + along * time, 0.0, time, normal.y, body, instance, id};
        limit = time;
    };
    const auto mesh_leaf = [&](const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf, BodyId body) {
        for (int i = 0; i < leaf.triangle_count; ++i)
            if (is_solid(scene_, mesh, leaf, i))
                triangle(triangle_of(at, leaf, i), body, at.instance, leaf.first_triangle + std::uint32_t(i));
    };
    const auto limit_f = [&] { return float(limit); };
    if (filter.static_scene)
        walk_scene(scene_, box, limit_f,
                   [&](const PlacedMesh& at, const scene::Mesh& mesh, const scene::BvhLeaf& leaf) {
                       mesh_leaf(at, mesh, leaf, {});
                   });
    if (!filter.bodies) return first;
    bodies_.find(box, slots_);
    for (const std::uint32_t slot : slots_) {
        const BodyId id = bodies_.id_of(slot);
        if (id == filter.except) continue;
        const Body& body = bodies_[slot];
        const Geometry& geometry = *body.geometry;
        if (geometry.shape.kind == ShapeKind::mesh) {
            const PlacedMesh at = placed(geometry, body.frame);
            walk_mesh(scene_, at, box, limit_f,
                      [&](const scene::Mesh& mesh, const scene::BvhLeaf& leaf) { mesh_leaf(at, mesh, leaf, id); });
            continue;
        }
        const LocalFrame frame(body.frame);
        if (!geometry.is_round()) {
            for (const Triangle& t : geometry.faces)
                triangle({frame.world_point(t.a), frame.world_point(t.b), frame.world_point(t.c)}, id, 0, 0);
            continue;
        }
        const DVec3 local = frame.point(from);
        const auto found = touch({local, local}, geometry.radius_m, frame.vector(along), geometry.core, limit);
        if (!found || (first && found->time == limit)) continue;
        const DVec3 normal = frame.world_vector(found->normal);
        first = Obstacle{normal, from + along * found->time, 0.0, found->time, normal.y, id, 0, 0};
        limit = found->time;
    }
    return first;
}

}  // namespace ff::physics
