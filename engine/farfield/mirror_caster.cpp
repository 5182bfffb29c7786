#include "engine/farfield/mirror_caster.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/core/jobs.h"
#include "engine/farfield/cast_cost_sum.h"

namespace ff::farfield {

PinholeView mirrored_view(const PinholeView& view, const MirrorPlane& plane, int step) {
    PinholeView mirrored = view;
    mirrored.position = view.position - 2.0 * plane.height_m * DVec3(plane.normal);
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3& a = view.world_from_camera[axis];
        mirrored.world_from_camera[axis] = a - 2.0f * glm::dot(a, plane.normal) * plane.normal;
    }
    mirrored.width = (view.width + step - 1) / step;
    mirrored.height = (view.height + step - 1) / step;
    mirrored.u_step = view.u_step * float(step);
    mirrored.v_step = view.v_step * float(step);
    mirrored.blend_within_m = 0.0f;
    mirrored.sway = {};  // about another eye; what is mirrored is coarser than leaves move
    return mirrored;
}

DepthPlane mirror_before(const PinholeView& mirrored, const MirrorPlane& plane, double lift_m) {
    const DVec3 normal = glm::transpose(DMat3(mirrored.world_from_camera)) * DVec3(plane.normal);
    const double inverse = 1.0 / (plane.height_m + lift_m);
    return {float(normal.x * inverse), float(normal.y * inverse), float(-normal.z * inverse)};
}

CastCost MirrorCaster::cast(const PinholeView& view, const DepthPlane& plane, std::span<const TileRequest> tiles,
                            VisibilityBuffer& out) {
    const beam::BeamView beam_view(view);
    CastCostSum shared;
    const std::span<const beam::BeamRequest> requests = requests_.gather(view, tiles);
    parallel_ranges(requests.size(), 1, [&](std::size_t begin, std::size_t end) {
        CastCost cost;
        for (std::size_t i = begin; i < end; ++i) {
            beam::BeamRequest request = requests[i];
            request.behind = &plane;
            beam::cast_tile(scene_, beam_view, request, out, cost);
        }
        shared.add(cost);
    });
    return shared.total();
}

}  // namespace ff::farfield
