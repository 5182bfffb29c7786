#include "engine/effects/mirrored_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::effects {
namespace {

using farfield::kTileSize;
using farfield::MovingSphere;

/// Reflections have at most a ray a pixel, and filter over a few of them: 8 x 8, and as many round them.
constexpr double kBlurPx = 20.0;
/// Of cosines.
constexpr double kRounding = 1e-12;

}  // namespace

void find_mirrored(const PinholeView& view, std::span<const MovingSphere> moving, std::vector<MovingSphere>& out) {
    constexpr double kLeastPx = 0.5;  // radius
    out.clear();
    out.reserve(moving.size());
    for (const MovingSphere& sphere : moving) {
        const double distance = glm::length(sphere.center - view.position) - sphere.radius;
        if (sphere.radius > kLeastPx * double(view.pixel_angle()) * distance) out.push_back(sphere);
    }
}

void MirroredMotion::begin_tile(int x, int y) {
    const auto ray = [&](double column, double row) {
        const DVec3 in_camera((column + 0.5) * double(view_.u_step) + double(view_.u_first),
                              (row + 0.5) * double(view_.v_step) + double(view_.v_first), -1.0);
        return glm::normalize(DMat3(view_.world_from_camera) * in_camera);
    };
    const double last = kTileSize - 1;
    middle_ = ray(x + 0.5 * last, y + 0.5 * last);
    double least = 1.0;
    for (const double i : {-kBlurPx, last + kBlurPx})
        for (const double j : {-kBlurPx, last + kBlurPx}) least = std::min(least, glm::dot(middle_, ray(x + i, y + j)));
    cosine_ = std::clamp(least, -1.0, 1.0);
    sine_ = std::sqrt(1.0 - cosine_ * cosine_);
}

bool MirroredMotion::shows(const farfield::MirrorPlane& plane) const {
    const DVec3 normal(plane.normal);
    return std::any_of(moving_.begin(), moving_.end(), [&](const MovingSphere& sphere) {
        const DVec3 from_eye = sphere.center - view_.position;
        const double above = glm::dot(normal, from_eye) + plane.height_m;
        if (above < -sphere.radius) return false;  // behind the mirror
        const DVec3 image = from_eye - 2.0 * above * normal;
        const double distance = glm::length(image);
        if (distance <= sphere.radius) return true;
        // The cone's half angle and the ball's together, by their cosine; from half a turn on they take in everything.
        const double sine = sphere.radius / distance, cosine = std::sqrt(1.0 - sine * sine);
        if (cosine_ <= -cosine) return true;
        return glm::dot(image, middle_) >= distance * (cosine_ * cosine - sine_ * sine - kRounding);
    });
}

}  // namespace ff::effects
