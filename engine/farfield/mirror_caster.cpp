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

void MirrorCaster::reserve(std::size_t mirrors, int width, int height) {
    if (requests_.size() < mirrors) requests_.resize(mirrors);
    for (beam::BeamRequests& requests : requests_) requests.reserve(width, height);
    views_.reserve(mirrors);
    beams_.reserve(mirrors * std::size_t(width / kTileSize + 1) * std::size_t(height / kTileSize + 1));
}

CastCost MirrorCaster::cast(std::span<const MirrorRequest> mirrors, VisibilityBuffer& out) {
    if (requests_.size() < mirrors.size()) requests_.resize(mirrors.size());
    views_.clear();
    beams_.clear();
    for (std::uint32_t i = 0; i < mirrors.size(); ++i) {
        views_.emplace_back(mirrors[i].view);
        for (beam::BeamRequest request : requests_[i].gather(mirrors[i].view, mirrors[i].tiles)) {
            request.behind = &mirrors[i].before;
            beams_.push_back({i, request});
        }
    }
    CastCostSum shared;
    parallel_ranges(beams_.size(), 1, [&](std::size_t begin, std::size_t end) {
        CastCost cost;
        for (std::size_t i = begin; i < end; ++i)
            beam::cast_tile(scene_, views_[beams_[i].mirror], beams_[i].request, out, cost);
        shared.add(cost);
    });
    return shared.total();
}

}  // namespace ff::farfield
