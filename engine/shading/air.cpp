#include "engine/shading/air.h"

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace ff::shading {

double way_out(const PlaneVec& from, const PlaneVec& along, double radius_m) {
    const double b = glm::dot(from, along);
    return -b + std::sqrt(std::max(0.0, b * b - glm::dot(from, from) + radius_m * radius_m));
}

bool hits_ground(const PlaneVec& from, const PlaneVec& along) {
    const double b = glm::dot(from, along);
    return b < 0.0 && glm::dot(from, from) - b * b < kGroundRadiusM * kGroundRadiusM;
}

DVec3 transmittance(const Air& air, const PlaneVec& from, const PlaneVec& along) {
    constexpr int kSteps = 10;
    if (hits_ground(from, along)) return DVec3(0.0);
    const double way = way_out(from, along, kTopRadiusM);
    DVec3 depth(0.0);
    for (int i = 0; i < kSteps; ++i) {
        // Steps grow: the air is densest where the ray begins.
        const double t0 = double(i) / kSteps, t1 = double(i + 1) / kSteps;
        const double at = way * 0.5 * (t0 * t0 + t1 * t1), step = way * (t1 * t1 - t0 * t0);
        depth += step * air.extinction(Air::density(glm::length(from + at * along) - kGroundRadiusM));
    }
    return glm::exp(-depth);
}

}  // namespace ff::shading
