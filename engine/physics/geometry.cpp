#include "engine/physics/geometry.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexPolyhedron.h>
#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/physics/numbers.h"

namespace ff::physics {
namespace {

// Bullet finds contacts between shapes shrunk by this and adds it again. Small, so that corners stay corners.
constexpr float kMargin_m = 0.004f;
constexpr int kMaxHullCorners = 64;  // more are thinned out: contacts cost by the corner
constexpr float kMaxSize_m = 1000.0f;

/// The faces that Bullet merged, as triangles, and a ball that fits between them.
void take_faces(const btConvexPolyhedron& hull, Geometry& out) {
    out.inner_radius_m = std::numeric_limits<double>::infinity();
    for (int f = 0; f < hull.m_faces.size(); ++f) {
        const btAlignedObjectArray<int>& corners = hull.m_faces[f].m_indices;
        const auto at = [&](int i) {
            const btVector3& v = hull.m_vertices[corners[i]];
            return DVec3(v.x(), v.y(), v.z());
        };
        for (int i = 2; i < corners.size(); ++i) {
            Triangle t{at(0), at(i - 1), at(i)};
            DVec3 normal = normal_of(t);
            if (normal == DVec3(0.0)) continue;
            if (glm::dot(normal, t.a) < 0.0) {  // the centre is inside
                std::swap(t.b, t.c);
                normal = -normal;
            }
            out.faces.push_back(t);
            out.normals.push_back(normal);
            out.inner_radius_m = std::min(out.inner_radius_m, glm::dot(normal, t.a));
        }
    }
}

/// Volume and centroid of a closed hull, summed over tetrahedra from one of its corners.
double volume_of(const btConvexHullComputer& hull, DVec3& centroid) {
    double volume = 0.0;
    DVec3 moment(0.0);
    const auto at = [&](int i) { return DVec3(hull.vertices[i].x(), hull.vertices[i].y(), hull.vertices[i].z()); };
    const DVec3 apex = at(0);
    for (int f = 0; f < hull.faces.size(); ++f) {
        const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[f]];
        const DVec3 a = at(first->getSourceVertex());
        for (const btConvexHullComputer::Edge* edge = first->getNextEdgeOfFace();
             edge->getTargetVertex() != first->getSourceVertex(); edge = edge->getNextEdgeOfFace()) {
            const DVec3 b = at(edge->getSourceVertex()), c = at(edge->getTargetVertex());
            const double six = std::abs(glm::dot(a - apex, glm::cross(b - apex, c - apex)));
            volume += six / 6.0;
            moment += (apex + a + b + c) * (six / 24.0);
        }
    }
    if (volume > 0.0) centroid = moment / volume;
    return volume;
}

Status make_hull(const scene::StaticScene& scene, const Shape& shape, Geometry& out) {
    const scene::Mesh& mesh = scene.meshes[shape.mesh];
    std::vector<Vec3> points;
    points.reserve(mesh.vertex_count);
    for (std::uint32_t i = 0; i < mesh.vertex_count; ++i)
        points.push_back(shape.body_from_mesh * scene.positions[mesh.first_vertex + i]);
    if (points.size() < 4) return usage_error("a hull of fewer than 4 points; expected a body with a volume");

    const auto hull_of = [](const float* xyz, int count, int stride, btConvexHullComputer& hull) {
        hull.compute(xyz, stride, count, 0.0f, 0.0f);
    };
    btConvexHullComputer hull;
    hull_of(&points[0].x, int(points.size()), int(sizeof(Vec3)), hull);
    DVec3 center(0.0);
    double volume = hull.vertices.size() < 4 ? 0.0 : volume_of(hull, center);
    if (volume > 0.0 && hull.vertices.size() > kMaxHullCorners) {
        btConvexHullShape full(&hull.vertices[0].x(), hull.vertices.size(), sizeof(btVector3));
        full.setMargin(0.0f);
        btShapeHull thinned(&full);
        if (thinned.buildHull(0.0f)) {
            hull_of(&thinned.getVertexPointer()[0].x(), thinned.numVertices(), int(sizeof(btVector3)), hull);
            volume = hull.vertices.size() < 4 ? 0.0 : volume_of(hull, center);
        }
    }
    if (!(volume > 1e-12)) return usage_error("a hull without a volume; expected points that are not in one plane");

    out.center_of_mass = center;
    auto made = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < hull.vertices.size(); ++i) {
        const DVec3 p = DVec3(hull.vertices[i].x(), hull.vertices[i].y(), hull.vertices[i].z()) - center;
        out.bounds.add(p);
        made->addPoint(btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z)), false);
    }
    made->setMargin(kMargin_m);
    made->recalcLocalAabb();
    if (!made->initializePolyhedralFeatures()) return usage_error("a hull whose faces cannot be told");
    take_faces(*made->getConvexPolyhedron(), out);
    const Vec3 size(out.bounds.extent());
    out.inertia_per_kg =
        Vec3(size.y * size.y + size.z * size.z, size.x * size.x + size.z * size.z, size.x * size.x + size.y * size.y) /
        12.0f;
    out.bullet.reset(made.release());
    return {};
}

Status make_box(const Shape& shape, Geometry& out) {
    const Vec3& h = shape.half_extents_m;
    auto made = std::make_unique<btBoxShape>(btVector3(h.x, h.y, h.z));
    made->setMargin(std::min(kMargin_m, 0.1f * std::min({h.x, h.y, h.z})));
    if (!made->initializePolyhedralFeatures()) return usage_error("a box whose faces cannot be told");
    // From its own numbers rather than Bullet's hull of it: exact.
    out.bounds = {-DVec3(h), DVec3(h)};
    take_faces(*made->getConvexPolyhedron(), out);
    out.inner_radius_m = double(std::min({h.x, h.y, h.z}));
    out.inertia_per_kg = Vec3(h.y * h.y + h.z * h.z, h.x * h.x + h.z * h.z, h.x * h.x + h.y * h.y) / 3.0f;
    out.bullet.reset(made.release());
    return {};
}

void make_round(const Shape& shape, Geometry& out) {
    const float r = shape.radius_m, h = shape.kind == ShapeKind::capsule ? shape.half_height_m : 0.0f;
    out.core = {DVec3(0.0, -double(h), 0.0), DVec3(0.0, double(h), 0.0)};
    out.radius_m = r;
    out.inner_radius_m = r;
    out.bounds = {-DVec3(r, h + r, r), DVec3(r, h + r, r)};
    if (shape.kind == ShapeKind::sphere) {
        out.bullet.reset(new btSphereShape(r));
        out.inertia_per_kg = Vec3(0.4f * r * r);
        return;
    }
    out.bullet.reset(new btCapsuleShape(r, 2.0f * h));
    // A cylinder and two half balls, by their shares of the volume.
    const float cylinder = 2.0f * h * r * r, balls = 4.0f / 3.0f * r * r * r, mass = cylinder + balls;
    const float along = (cylinder * 0.5f * r * r + balls * 0.4f * r * r) / mass;
    const float across =
        (cylinder * (r * r / 4.0f + h * h / 3.0f) + balls * (0.4f * r * r + h * h + 0.75f * h * r)) / mass;
    out.inertia_per_kg = Vec3(across, along, across);
}

}  // namespace

Geometry::Geometry() = default;
Geometry::~Geometry() = default;

void DeleteBulletShape::operator()(btConvexShape* shape) const {
    delete shape;
}

Result<std::shared_ptr<const Geometry>> make_geometry(const scene::StaticScene& scene, const Shape& shape) {
    auto out = std::make_shared<Geometry>();
    out->shape = shape;
    switch (shape.kind) {
        case ShapeKind::box:
            for (int axis = 0; axis < 3; ++axis)
                FF_TRY(check_range("half_extents_m", shape.half_extents_m[axis], 1e-3f, kMaxSize_m));
            FF_TRY(make_box(shape, *out));
            break;
        case ShapeKind::capsule:
            FF_TRY(check_range("half_height_m", shape.half_height_m, 0.0f, kMaxSize_m));
            [[fallthrough]];
        case ShapeKind::sphere:
            FF_TRY(check_range("radius_m", shape.radius_m, 1e-3f, kMaxSize_m));
            make_round(shape, *out);
            break;
        case ShapeKind::hull:
        case ShapeKind::mesh: {
            if (shape.mesh >= scene.meshes.size())
                return usage_error(fmt::format("mesh {} of a scene of {}", shape.mesh, scene.meshes.size()));
            const float det = glm::determinant(shape.body_from_mesh);
            if (!std::isfinite(det) || std::abs(det) < 1e-12f)
                return usage_error(fmt::format("body_from_mesh has determinant {}; expected one that is not 0", det));
            if (shape.kind == ShapeKind::hull) {
                FF_TRY(make_hull(scene, shape, *out));
            } else {
                const Box3& box = scene.meshes[shape.mesh].bounds;
                if (box.is_empty()) return usage_error("a mesh without triangles");
                for (int corner = 0; corner < 8; ++corner)
                    out->bounds.add(DVec3(shape.body_from_mesh * Vec3((corner & 1) != 0 ? box.high.x : box.low.x,
                                                                      (corner & 2) != 0 ? box.high.y : box.low.y,
                                                                      (corner & 4) != 0 ? box.high.z : box.low.z)));
            }
            break;
        }
        default:
            return usage_error(fmt::format("shape kind {}", int(shape.kind)));
    }
    return std::shared_ptr<const Geometry>(std::move(out));
}

bool is_same(const Shape& a, const Shape& b) {
    if (a.kind != b.kind) return false;
    switch (a.kind) {
        case ShapeKind::box:
            return a.half_extents_m == b.half_extents_m;
        case ShapeKind::sphere:
            return a.radius_m == b.radius_m;
        case ShapeKind::capsule:
            return a.radius_m == b.radius_m && a.half_height_m == b.half_height_m;
        default:
            return a.mesh == b.mesh && a.body_from_mesh == b.body_from_mesh;
    }
}

}  // namespace ff::physics
