#include "tests/hardcases/exact_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace ff::hardcases {

ExactPixels::ExactPixels(const scene::StaticScene& scene, const PinholeView& view, const PixelRules& rules)
    : view_(view), rules_(rules) {
    const LVec3 forward = -LVec3(view.world_from_camera[2]);
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const scene::Instance& instance = scene.instances[i];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        first_of_instance_.push_back(triangles_.size());
        for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
            Triangle out{.instance = i, .triangle = t};
            out.nearest_m = std::numeric_limits<long double>::infinity();
            out.farthest_m = -out.nearest_m;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t index = 3 * (std::size_t(mesh.first_triangle) + t) + k;
                const LVec3 p(scene.positions[mesh.first_vertex + scene.indices[index]]);
                out.corner[k] = glm::mat<3, 3, long double>(instance.world_from_mesh) * p +
                                (LVec3(instance.position) - LVec3(view.position));
                const long double depth = glm::dot(forward, out.corner[k]);
                out.nearest_m = std::min(out.nearest_m, depth);
                out.farthest_m = std::max(out.farthest_m, depth);
            }
            out.normal = glm::cross(out.corner[1] - out.corner[0], out.corner[2] - out.corner[0]);
            long double longest = 0.0;
            for (std::size_t k = 0; k < 3; ++k)
                longest = std::max(longest, glm::length(out.corner[(k + 1) % 3] - out.corner[k]));
            out.height = longest > 0.0 ? glm::length(out.normal) / longest : 0.0;
            triangles_.push_back(out);
        }
    }
}

ExactPixels::Crossing ExactPixels::cross(const Triangle& t, const LVec3& direction) const {
    const long double along = glm::dot(t.normal, direction), area2 = glm::dot(t.normal, t.normal);
    if (along == 0.0 || area2 == 0.0) return {-1.0, -1.0, 0.0};
    Crossing out{.depth = glm::dot(t.normal, t.corner[0]) / along};
    const LVec3 q = out.depth * direction - t.corner[0];
    const long double b1 = glm::dot(glm::cross(q, t.corner[2] - t.corner[0]), t.normal) / area2;
    const long double b2 = glm::dot(glm::cross(t.corner[1] - t.corner[0], q), t.normal) / area2;
    out.inside = std::min({b1, b2, 1 - b1 - b2});
    // A step sideways of one pixel moves the crossing by so much over the triangle, the more the flatter it is seen.
    const long double cosine = std::abs(along) / (glm::length(t.normal) * glm::length(direction));
    out.doubt = rules_.edge_px * view_.pixel_angle() * std::abs(out.depth) / (t.height * cosine);
    return out;
}

std::string ExactPixels::problem(int x, int y, const farfield::VisibilityBuffer& seen, double& error) const {
    const std::size_t at = seen.index(x, y);
    const LVec3 direction(view_.direction(x, y));
    const Triangle* found = nullptr;
    Crossing at_found{};
    if (seen.instance[at] != farfield::kSkyInstance) {
        if (seen.instance[at] >= first_of_instance_.size()) return fmt::format("pixel {}, {}: not answered", x, y);
        found = &triangles_[first_of_instance_[seen.instance[at]] + seen.triangle[at]];
        at_found = cross(*found, direction);
    }
    // The nearest that certainly covers the pixel, and whether something that may cover it lies where the found one
    // does.
    const Triangle* nearest = nullptr;
    long double nearest_m = std::numeric_limits<long double>::infinity();
    bool is_of_plane = false;
    for (const Triangle& t : triangles_) {
        if (t.nearest_m > nearest_m || t.farthest_m <= 0.0) continue;
        const Crossing c = cross(t, direction);
        if (!(c.depth > 0.0) || c.inside < -c.doubt) continue;
        is_of_plane = is_of_plane || std::abs(c.depth - at_found.depth) <= rules_.depth * c.depth;
        if (c.depth < nearest_m && c.inside > c.doubt) {
            nearest = &t;
            nearest_m = c.depth;
        }
    }
    bool is_right = found == nearest;
    if (found != nullptr) {
        is_right = at_found.depth > 0.0 && at_found.depth <= nearest_m * (1.0 + rules_.depth) &&
                   (at_found.inside >= -at_found.doubt || (rules_.any_of_plane && is_of_plane));
        if (is_right) error = std::abs(double(seen.depth[at] / at_found.depth) - 1.0);
    }
    if (is_right) return {};
    const auto name = [](const Triangle* t) {
        return t == nullptr ? std::string("sky") : fmt::format("{}/{}", t->instance, t->triangle);
    };
    return fmt::format("pixel {}, {} shows {} at {} m, expected {} at {} m", x, y, name(found), seen.depth[at],
                       name(nearest), double(nearest_m));
}

void ExactPixels::count(const farfield::VisibilityBuffer& seen, Trial& trial) const {
    for (int y = 0; y < view_.height; ++y)
        for (int x = 0; x < view_.width; ++x) {
            double error = 0.0;
            const std::string what = problem(x, y, seen, error);
            trial.count(what.empty(), error, [&] { return what; });
        }
}

}  // namespace ff::hardcases
