// Single rays.

#include "engine/farfield/grid_traversal.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/grid_triangle.h"

namespace ff::farfield::grid {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

/// Calls visit(cell) for the cells along the ray from t = 0, nearest first, until visit's limit: it returns the t
/// beyond which nothing is wanted.
template <class Visit>
void walk_cells(const Grid& grid, const Vec3& origin, const Vec3& direction, float limit, Visit&& visit) {
    if (grid.count[0] == 0) return;
    const Vec3 o = (origin - grid.low) * grid.cells_per_m, d = direction * grid.cells_per_m;
    float enter = 0.0f, leave = limit;
    Vec3 inverse;
    for (int axis = 0; axis < 3; ++axis) {
        const float size = float(grid.count[axis]);
        if (d[axis] == 0.0f) {
            if (o[axis] < 0.0f || o[axis] > size) return;
            inverse[axis] = kInf;
            continue;
        }
        inverse[axis] = 1.0f / d[axis];
        const float a = -o[axis] * inverse[axis], b = (size - o[axis]) * inverse[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    if (!(enter <= leave)) return;
    int at[3], step[3];
    float next[3], delta[3];
    for (int axis = 0; axis < 3; ++axis) {
        const float p = d[axis] == 0.0f ? o[axis] : o[axis] + d[axis] * enter;
        at[axis] = std::clamp(int(std::floor(p)), 0, grid.count[axis] - 1);
        step[axis] = d[axis] < 0.0f ? -1 : 1;
        delta[axis] = std::fabs(inverse[axis]);
        next[axis] = d[axis] == 0.0f ? kInf : (float(at[axis] + (step[axis] > 0)) - o[axis]) * inverse[axis];
    }
    while (true) {
        const std::size_t cell = grid.cell(at[0], at[1], at[2]);
        if (grid.clearance[cell] == 0) leave = std::min(leave, visit(cell));
        // Many steps at once where nothing is near, one elsewhere.
        const int steps = std::max(1, int(grid.clearance[cell]) - 1);
        for (int s = 0; s < steps; ++s) {
            const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
            if (next[axis] > leave) return;
            at[axis] += step[axis];
            if (at[axis] < 0 || at[axis] >= grid.count[axis]) return;
            next[axis] += delta[axis];
        }
    }
}

/// One triangle against one ray, by the signs of three volumes; a shared edge gives both neighbours the same number.
void test_triangle(const GridWorld& world, std::uint32_t instance_id, std::uint32_t triangle, const Vec3& origin,
                   const Vec3& direction, const RayCone& cone, RayHit& hit) {
    const scene::StaticScene& scene = world.scene;
    const scene::Instance& instance = scene.instances[instance_id];
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const std::uint32_t* corner = &scene.indices[3 * (std::size_t(mesh.first_triangle) + triangle)];
    const Vec3* positions = scene.positions.data() + mesh.first_vertex;
    const Vec3 a = positions[corner[0]] - origin, b = positions[corner[1]] - origin, c = positions[corner[2]] - origin;
    const float at_a = glm::dot(direction, glm::cross(c, b));
    const float at_b = glm::dot(direction, glm::cross(a, c));
    const float at_c = glm::dot(direction, glm::cross(b, a));
    const float least = std::min(at_a, std::min(at_b, at_c)), most = std::max(at_a, std::max(at_b, at_c));
    const Vec3 size = glm::abs(direction);
    const float rounding = volume_rounding(a, b, c) * std::max(size.x, std::max(size.y, size.z));
    if (least < -rounding && most > rounding) return;
    const float volume = at_a + at_b + at_c;
    float t;
    if (least > rounding || most < -rounding) {
        const Vec3 normal = glm::cross(b - a, c - a);
        t = glm::dot(a, normal) / glm::dot(direction, normal);
    } else {
        t = float(
            meet_in_double({positions[corner[0]], positions[corner[1]], positions[corner[2]]}, origin, direction));
    }
    if (!(t >= 0.0f && t < hit.t)) return;
    if ((mesh.material_flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) != 0) {
        if (volume == 0.0f) return;  // no place on it that could be looked up
        const AlphaSurface surface = make_alpha_surface(scene, instance, instance_id, triangle);
        const bool in_layer = is_in_layer(surface, t, cone.layer_depth);
        const SwayPlace place{cone.sway, t * (instance.world_from_mesh * direction)};
        if (!is_opaque_at(surface, at_b / volume, at_c / volume, cone.pixel_angle * t, in_layer, place)) return;
    }
    hit = {instance_id, triangle, t};
}

}  // namespace

RayHit cast_ray(const GridWorld& world, const Ray& ray, const RayCone& cone, CastCost& cost) {
    RayHit hit{kSkyInstance, 0, kInf};
    ++cost.rays;
    const Vec3 origin(ray.origin - world.scene.origin);
    const float sum = origin.x + origin.y + origin.z + ray.direction.x + ray.direction.y + ray.direction.z;
    if (!std::isfinite(sum) || glm::dot(ray.direction, ray.direction) == 0.0f) return hit;
    // An instance reaches into many cells of the top grid; the last few are remembered.
    std::uint32_t mailbox[8];
    std::fill(std::begin(mailbox), std::end(mailbox), kSkyInstance);
    walk_cells(world.top, origin, ray.direction, kInf, [&](std::size_t top_cell) {
        ++cost.nodes;
        for (std::uint32_t i = world.top.first_item[top_cell]; i < world.top.first_item[top_cell + 1]; ++i) {
            const std::uint32_t id = world.top.items[i];
            if (mailbox[id % 8] == id) continue;
            mailbox[id % 8] = id;
            const scene::Instance& instance = world.scene.instances[id];
            const Placement& placement = world.placements[id];
            Vec3 o(ray.origin - instance.position), d = ray.direction;
            if (placement.is_turned) o = placement.mesh_from_world * o, d = placement.mesh_from_world * d;
            const Grid& grid = world.meshes[instance.mesh];
            walk_cells(grid, o, d, hit.t, [&](std::size_t cell) {
                ++cost.nodes;
                for (std::uint32_t k = grid.first_item[cell]; k < grid.first_item[cell + 1]; ++k) {
                    ++cost.triangles;
                    test_triangle(world, id, grid.items[k], o, d, cone, hit);
                }
                return hit.t;
            });
        }
        return hit.t;
    });
    return hit;
}

}  // namespace ff::farfield::grid
