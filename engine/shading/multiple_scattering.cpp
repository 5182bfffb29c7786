#include "engine/shading/multiple_scattering.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace ff::shading {
namespace {

constexpr double kTopM = kTopRadiusM - kGroundRadiusM;
/// Clean air keeps less than a quarter of its blue light from one order to the next: what is left out is below 1e-5.
constexpr int kOrders = 8;

/// Heights lie denser near the ground: node i at kTopM (i / (count - 1))^2.
struct Between {
    int below;
    double t;

    Between(double height_m, int count) {
        const double place = std::sqrt(std::clamp(height_m / kTopM, 0.0, 1.0)) * (count - 1);
        below = std::min(int(place), count - 2);
        t = place - below;
    }
};

}  // namespace

MultipleScattering::MultipleScattering(const Air& air, double sun_elevation_rad)
    : first_sun_rad_(sun_elevation_rad - kReachRad) {
    constexpr int kDirections = 16, kSteps = 14;
    // How much of the mean radiance at each height a height receives from each direction, and what it sees of the
    // ground.
    struct Ray {
        double y;
        std::array<DVec3, kHeights> from_height{};
        DVec3 from_ground{0.0};
    };
    std::array<std::array<Ray, kDirections>, kHeights> rays;
    for (int i = 0; i < kHeights; ++i) {
        const double share = double(i) / (kHeights - 1);
        const PlaneVec eye(0.0, kGroundRadiusM + std::max(1.0, kTopM * share * share - 1.0));
        for (int j = 0; j < kDirections; ++j) {
            Ray& ray = rays[std::size_t(i)][std::size_t(j)];
            ray = {.y = (2 * j + 1.0) / kDirections - 1.0};
            const PlaneVec along(std::sqrt(1.0 - ray.y * ray.y), ray.y);
            const bool ends_below = hits_ground(eye, along);
            // To the nearer of the ground's two crossings.
            const double way = ends_below ? -2.0 * glm::dot(eye, along) - way_out(eye, along, kGroundRadiusM)
                                          : way_out(eye, along, kTopRadiusM);
            const DVec3 through =
                march<kSteps>(air, eye, along, way, [&](const PlaneVec& point, const auto& density, const DVec3& seen) {
                    const DVec3 sent = seen * air.scattering(density);
                    const Between at(glm::length(point) - kGroundRadiusM, kHeights);
                    ray.from_height[std::size_t(at.below)] += (1.0 - at.t) * sent;
                    ray.from_height[std::size_t(at.below + 1)] += at.t * sent;
                });
            if (ends_below) ray.from_ground = through;
        }
    }

    for (int s = 0; s < kSuns; ++s) {
        const double sun = first_sun_rad_ + 2.0 * kReachRad * s / (kSuns - 1);
        const PlaneVec to_sun(std::cos(sun), std::sin(sun));
        std::array<DVec3, kHeights>& sum = mean_[std::size_t(s)];
        sum.fill(DVec3(0.0));
        // The order before: of the first one, the sun's light itself.
        std::array<DVec3, kHeights> last;
        for (int i = 0; i < kHeights; ++i) {
            const double share = double(i) / (kHeights - 1);
            last[std::size_t(i)] =
                transmittance(air, {0.0, kGroundRadiusM + std::max(1.0, kTopM * share * share)}, to_sun) / (4.0 * kPi);
        }
        DVec3 ground = kGroundAlbedo * 4.0 * last[0] * std::max(0.0, to_sun.y);
        for (int order = 0; order < kOrders; ++order) {
            std::array<DVec3, kHeights> next;
            DVec3 on_ground(0.0);
            for (int i = 0; i < kHeights; ++i) {
                DVec3 all(0.0);
                for (const Ray& ray : rays[std::size_t(i)]) {
                    DVec3 light = ground * ray.from_ground;
                    for (std::size_t k = 0; k < kHeights; ++k) light += last[k] * ray.from_height[k];
                    all += light;
                    if (i == 0 && ray.y > 0.0) on_ground += light * (4.0 / kDirections * ray.y);
                }
                next[std::size_t(i)] = all / double(kDirections);
                sum[std::size_t(i)] += next[std::size_t(i)];
            }
            last = next;
            ground = kGroundAlbedo * on_ground;
        }
    }
}

DVec3 MultipleScattering::at(double height_m, double sun_elevation_rad) const {
    const Between height(height_m, kHeights);
    const double place = std::clamp((sun_elevation_rad - first_sun_rad_) / (2.0 * kReachRad), 0.0, 1.0) * (kSuns - 1);
    const int sun = std::min(int(place), kSuns - 2);
    const auto of_sun = [&](int s) {
        const auto& column = mean_[std::size_t(s)];
        return glm::mix(column[std::size_t(height.below)], column[std::size_t(height.below + 1)], height.t);
    };
    return glm::mix(of_sun(sun), of_sun(sun + 1), place - sun);
}

}  // namespace ff::shading
