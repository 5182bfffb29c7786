#include "engine/visibility/frustum.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace ff::visibility {

Frustum make_frustum(const PinholeView& view) {
    const double u0 = view.u_first, u1 = u0 + double(view.u_step) * view.width;
    const double v1 = view.v_first, v0 = v1 + double(view.v_step) * view.height;  // rows go down
    // In camera space a point at (x, y, z) has depth -z, and lies right of the left edge where x >= u0 * depth.
    const DVec3 planes[Frustum::kPlanes] = {{1, 0, u0}, {-1, 0, -u1}, {0, 1, v0}, {0, -1, -v1}, {0, 0, -1}};
    const DMat3 world_from_camera(view.world_from_camera);
    Frustum frustum;
    frustum.position = view.position;
    for (int i = 0; i < Frustum::kPlanes; ++i) frustum.normals[i] = world_from_camera * glm::normalize(planes[i]);
    return frustum;
}

bool is_outside(const Frustum& frustum, const DBox3& box) {
    if (box.is_empty()) return true;
    const DVec3 center = box.center() - frustum.position, half = 0.5 * box.extent();
    for (const DVec3& n : frustum.normals)
        if (glm::dot(n, center) + glm::dot(glm::abs(n), half) < 0.0) return true;
    return false;
}

}  // namespace ff::visibility
