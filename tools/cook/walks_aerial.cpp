#include "tools/cook/walks_aerial.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cook/walks_frames.h"

namespace ff::cook {
namespace {

constexpr double kRate_hz = 30.0;
constexpr double kSmallScene_m = 600.0;
constexpr double kLargestRadius_m = 320.0;
constexpr double kOrbitElevation_deg = 22.0;
constexpr double kFlyRadius_m = 14.0;  // of the circle flown in the view over the scene
constexpr double kFastest_m_s = 29.0;
constexpr double kFlyClearance_m = 1.5;

double smooth_step(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

// A node near the start with nothing but sky above a metre around it.
std::uint32_t find_launch_node(const GroundMap& map, std::uint32_t start) {
    const GroundNode& first = map.nodes[start];
    const PointXZ from = map.middle_of(first);
    std::uint32_t best = start;
    double best_distance = 40.0;
    for (std::uint32_t n = 0; n < map.nodes.size(); ++n) {
        const GroundNode& node = map.nodes[n];
        if (!node.is_open || node.region != first.region) continue;
        const PointXZ at = map.middle_of(node);
        const double distance = std::hypot(at.x - from.x, at.z - from.z);
        if (distance < best_distance && map.top_near(at.x, at.z, 1.0) <= node.y + map.base_y + 1.0)
            best = n, best_distance = distance;
    }
    return best;
}

std::vector<WalkFrame> fly(const DVec3& eye, double yaw_deg, double height, double radius, int frames) {
    const DVec3 ahead(std::sin(radians_of(yaw_deg)), 0.0, -std::cos(radians_of(yaw_deg)));
    const DVec3 right(-ahead.z, 0.0, ahead.x);
    std::vector<WalkFrame> out(static_cast<std::size_t>(frames));
    for (std::size_t f = 0; f < out.size(); ++f) {
        const double t = double(f) / double(frames - 1);
        const double up = 0.5 - 0.5 * std::cos(2.0 * kPi * t);
        const double around = 2.0 * kPi * smooth_step((t - 0.15) / 0.7);
        out[f].position = eye + DVec3(0.0, height * up, 0.0) + ahead * (radius * (1.0 - std::cos(around))) +
                          right * (radius * std::sin(around));
        out[f].yaw_deg = yaw_deg + 360.0 * smooth_step(t);
        out[f].pitch_deg = -35.0 * up;
    }
    return out;
}

double fastest_m_s(const std::vector<WalkFrame>& frames) {
    double step = 0;
    for (std::size_t f = 1; f < frames.size(); ++f)
        step = std::max(step, glm::length(frames[f].position - frames[f - 1].position));
    return step * kRate_hz;
}

// Above everything around, or in the free shaft above the start.
bool is_free(const GroundMap& map, const std::vector<WalkFrame>& frames) {
    const DVec3 start = frames.front().position;
    return std::all_of(frames.begin(), frames.end(), [&](const WalkFrame& frame) {
        const DVec3& p = frame.position;
        return std::hypot(p.x - start.x, p.z - start.z) < 0.25 || p.y >= map.top_near(p.x, p.z, 2.0) + kFlyClearance_m;
    });
}

}  // namespace

SceneCircle scene_circle(const StaticTriangles& triangles, const DensityMap& density, double ground_y) {
    const DBox3& bounds = triangles.bounds();
    if (bounds.is_empty()) return {DVec3(0.0, ground_y + 1.0, 0.0), 10.0};
    const DVec3 extent = bounds.extent();
    SceneCircle circle;
    if (std::max(extent.x, extent.z) <= kSmallScene_m) {
        circle.center = bounds.center();
        circle.radius_m = 0.5 * std::hypot(extent.x, extent.z);
    } else {
        // Four fifths of the triangles around the densest place, but no more than can be seen well.
        const PointXZ place = densest_place(density);
        const double all = double(density.sums.back());
        circle.radius_m = 100.0;
        while (circle.radius_m < kLargestRadius_m &&
               double(density.triangles_near(place.x, place.z, circle.radius_m)) < 0.8 * all)
            circle.radius_m = std::min(circle.radius_m * 1.1, kLargestRadius_m);
        circle.center = DVec3(place.x, 0.0, place.z);
    }
    circle.center.y = std::min(ground_y + 0.1 * circle.radius_m, std::max(ground_y, bounds.center().y));
    return circle;
}

std::vector<WalkFrame> orbit(const SceneCircle& circle, const DensityMap& density, int frames) {
    const double ring = 1.25 * circle.radius_m;
    double y = circle.center.y + std::tan(radians_of(kOrbitElevation_deg)) * ring;
    std::vector<WalkFrame> out(static_cast<std::size_t>(frames));
    for (std::size_t f = 0; f < out.size(); ++f) {
        const double angle = 2.0 * kPi * double(f) / frames;  // from the south eastwards
        out[f].position = circle.center + DVec3(std::sin(angle), 0.0, std::cos(angle)) * ring;
        y = std::max(y, 0.08 * ring + density.top_near(out[f].position.x, out[f].position.z, 0.1 * ring));
    }
    for (WalkFrame& frame : out) frame.position.y = y;
    look_at(out, circle.center);
    return out;
}

std::vector<WalkFrame> fly_over(const GroundMap& map, std::uint32_t start, double yaw_deg, const SceneCircle& circle,
                                int frames) {
    const GroundNode& node = map.nodes[find_launch_node(map, start)];
    const PointXZ at = map.middle_of(node);
    const double ground = node.y + map.base_y;
    const DVec3 eye(at.x, ground + kEyeHeight_m, at.z);
    const double around = map.top_near(at.x, at.z, 2.0 * kFlyRadius_m) - ground;
    double height = std::clamp(0.6 * circle.radius_m + std::max(0.0, around), 20.0, 110.0);
    if (!node.is_outdoors()) height = std::min(height, node.ceiling - node.y - kEyeHeight_m - 0.3);
    std::vector<WalkFrame> out;
    for (const double radius : {kFlyRadius_m, 9.0, 5.0, 2.0, 0.0}) {
        out = fly(eye, yaw_deg, height, radius, frames);
        while (fastest_m_s(out) > kFastest_m_s && height > 1.0)  // the circle alone is slow enough
            height *= 0.97, out = fly(eye, yaw_deg, height, radius, frames);
        if (is_free(map, out)) break;
    }
    return out;
}

ObjectView object_view(const DBox3& bounds) {
    if (bounds.is_empty()) return {DVec3(0.0, 1.0, 0.0), 10.0, kEyeHeight_m};
    const double radius = std::max(0.05, 0.5 * glm::length(bounds.extent()));
    ObjectView view{bounds.center(), 1.9 * radius, bounds.low.y + kEyeHeight_m};
    // Small things are looked at from a little above.
    if (bounds.extent().y < kEyeHeight_m) view.eye_y = std::min(view.eye_y, view.center.y + 0.6 * radius);
    return view;
}

std::vector<WalkFrame> walk_around(const ObjectView& view, double speed_m_s, double rise_m, int frames) {
    const double turn = std::min(2.0 * kPi, speed_m_s / kRate_hz * (frames - 1) / view.distance_m);
    std::vector<WalkFrame> out(static_cast<std::size_t>(frames));
    for (std::size_t f = 0; f < out.size(); ++f) {
        const double t = double(f) / double(frames - 1);
        out[f].position = DVec3(view.center.x + view.distance_m * std::sin(turn * t),
                                view.eye_y + rise_m * (0.5 - 0.5 * std::cos(2.0 * kPi * t)),
                                view.center.z + view.distance_m * std::cos(turn * t));
    }
    look_at(out, view.center);
    return out;
}

}  // namespace ff::cook
