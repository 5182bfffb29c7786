#include "engine/farfield/sun_rays_reference.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/sun_rays.h"

namespace ff::farfield {
namespace {

using scene::BvhLeaf;
using scene::BvhNode;

// Whether a ray meets a child's box, widened by what rounded coordinates may be off.
bool meets_box(const BvhNode& node, int lane, const DVec3& origin, const DVec3& direction) {
    const DVec3 low(node.low_x[lane], node.low_y[lane], node.low_z[lane]);
    const DVec3 high(node.high_x[lane], node.high_y[lane], node.high_z[lane]);
    double enter = 0.0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double slack = 1e-6 * std::max(std::abs(low[axis]), std::abs(high[axis]));
        const double from = low[axis] - slack - origin[axis], to = high[axis] + slack - origin[axis];
        if (direction[axis] == 0.0) {
            if (from > 0.0 || to < 0.0) return false;
            continue;
        }
        enter = std::max(enter, std::min(from / direction[axis], to / direction[axis]));
        leave = std::min(leave, std::max(from / direction[axis], to / direction[axis]));
    }
    return enter <= leave;
}

// Calls on_leaf(id), which answers whether the search is over.
template <class OnLeaf>
bool any_leaf(const BvhNode* nodes, std::uint32_t id, const DVec3& origin, const DVec3& direction, OnLeaf&& on_leaf) {
    const BvhNode& node = nodes[id];
    for (int lane = 0; lane < scene::kBvhWidth; ++lane) {
        const std::uint32_t child = node.child[lane];
        if (child == scene::kBvhEmpty || !meets_box(node, lane, origin, direction)) continue;
        const bool found = (child & scene::kBvhLeafBit) != 0 ? on_leaf(child & ~scene::kBvhLeafBit)
                                                             : any_leaf(nodes, child, origin, direction, on_leaf);
        if (found) return true;
    }
    return false;
}

DVec3 corner_of(const scene::StaticScene& scene, const scene::Mesh& mesh, std::uint32_t triangle, int corner) {
    const std::size_t index = 3 * (std::size_t(mesh.first_triangle) + triangle) + std::size_t(corner);
    return DVec3(scene.positions[mesh.first_vertex + scene.indices[index]]);
}

// Whether the ray meets the triangle (edges belong to it), and where: barycentrics of corners 1 and 2.
bool meets_triangle(const DVec3 (&p)[3], const DVec3& origin, const DVec3& direction, double& b1, double& b2) {
    const DVec3 ab = p[1] - p[0], ac = p[2] - p[0], from = origin - p[0];
    const DVec3 across = glm::cross(direction, ac);
    const double det = glm::dot(ab, across);
    if (det == 0.0) return false;
    b1 = glm::dot(from, across) / det;
    const DVec3 up = glm::cross(from, ab);
    b2 = glm::dot(direction, up) / det;
    return b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 && glm::dot(ac, up) / det > 0.0;
}

}  // namespace

bool is_occluded_reference(const scene::StaticScene& scene, std::uint32_t first_id, const ShadowRay& ray) {
    if (scene.instance_nodes.empty()) return false;
    const DVec3 from_origin = ray.origin - scene.origin;
    return any_leaf(scene.instance_nodes.data(), 0, from_origin, ray.direction, [&](std::uint32_t id) {
        const scene::Instance& instance = scene.instances[id];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        const DMat3 mesh_from_world = glm::inverse(DMat3(instance.world_from_mesh));
        const DVec3 origin = mesh_from_world * (ray.origin - instance.position);
        const DVec3 direction = mesh_from_world * ray.direction;
        const BvhNode* nodes = scene.mesh_nodes.data() + mesh.first_node;
        return any_leaf(nodes, 0, origin, direction, [&](std::uint32_t leaf_id) {
            const BvhLeaf& leaf = scene.mesh_leaves[mesh.first_leaf + leaf_id];
            for (std::uint32_t i = 0; i < leaf.triangle_count; ++i) {
                const std::uint32_t triangle = leaf.first_triangle + i;
                if (first_id + id == ray.own_instance && triangle == ray.own_triangle) continue;
                const DVec3 p[3] = {corner_of(scene, mesh, triangle, 0), corner_of(scene, mesh, triangle, 1),
                                    corner_of(scene, mesh, triangle, 2)};
                double b1 = 0, b2 = 0;
                if (!meets_triangle(p, origin, direction, b1, b2)) continue;
                const AlphaSurface surface = make_alpha_surface(scene, instance, id, triangle);
                if (is_opaque_at(surface, float(b1), float(b2), ray.footprint_m)) return true;
            }
            return false;
        });
    });
}

SunQuestion sun_question_reference(const scene::StaticScene& scene, const PinholeView& view,
                                   const VisibilityBuffer& visibility, std::span<const scene::Instance> dynamic,
                                   const Vec3& to_sun, int x, int y) {
    const std::size_t at = visibility.index(x, y);
    const std::uint32_t id = visibility.instance[at];
    if (id == kSkyInstance || id == kUnresolved) return {};
    const std::size_t count = scene.instances.size();
    const scene::Instance& instance = id < count ? scene.instances[id] : dynamic[id - count];
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const DMat3 world_from_mesh(instance.world_from_mesh);
    const std::uint32_t triangle = visibility.triangle[at];
    const DVec3 a = world_from_mesh * corner_of(scene, mesh, triangle, 0);
    const DVec3 b = world_from_mesh * corner_of(scene, mesh, triangle, 1);
    const DVec3 c = world_from_mesh * corner_of(scene, mesh, triangle, 2);
    const auto depth = double(visibility.depth[at]);
    const DVec3 direction =
        DMat3(view.world_from_camera) * DVec3((x + 0.5) * double(view.u_step) + double(view.u_first),
                                              (y + 0.5) * double(view.v_step) + double(view.v_first), -1.0);
    DVec3 normal = glm::cross(b - a, c - a);
    if (glm::dot(normal, direction) > 0.0) normal = -normal;
    if (!(glm::dot(normal, DVec3(to_sun)) > 0.0)) return {SunQuestion::Kind::turned_away, {}};
    const auto offset = double(sun_ray_offset(float(depth), reach_of(mesh, instance)));
    return {SunQuestion::Kind::ray,
            {.origin = view.position + depth * direction + glm::normalize(normal) * offset,
             .direction = DVec3(to_sun),
             .own_instance = id,
             .own_triangle = triangle,
             .footprint_m = float(depth) * view.pixel_angle()}};
}

}  // namespace ff::farfield
