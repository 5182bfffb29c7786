#include "game/beacons/path.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::beacons {
namespace {
constexpr double kLeastStep = 0.05, kClosedWithin = 2.0;  // metres
}

Path make_path(const scene::Walk& walk) {
    Path path;
    for (const scene::WalkFrame& frame : walk.frames) {
        const double step = path.points.empty() ? 0.0 : glm::distance(frame.position, path.points.back());
        if (!path.points.empty() && step < kLeastStep) continue;
        path.at_m.push_back(path.points.empty() ? 0.0 : path.at_m.back() + step);
        path.points.push_back(frame.position);
    }
    if (path.points.size() < 2) return {};
    path.closed = glm::distance(path.points.front(), path.points.back()) < kClosedWithin;
    return path;
}

PathPoint point_on(const Path& path, double distance_m) {
    const double length = path.length_m();
    double at = std::fmod(distance_m, path.closed ? length : 2.0 * length);
    const bool back = !path.closed && at > length;
    if (back) at = 2.0 * length - at;
    const auto next = std::upper_bound(path.at_m.begin(), path.at_m.end() - 1, at);
    const auto i = std::size_t(std::max<std::ptrdiff_t>(1, next - path.at_m.begin()));
    const double share = (at - path.at_m[i - 1]) / (path.at_m[i] - path.at_m[i - 1]);
    const DVec3 step = path.points[i] - path.points[i - 1];
    const double sign = back ? -1.0 : 1.0;
    return {path.points[i - 1] + share * step, std::atan2(sign * step.x, -sign * step.z)};
}

}  // namespace ff::beacons
