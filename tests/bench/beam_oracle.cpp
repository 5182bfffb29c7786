#include "tests/bench/beam_oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <vector>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/visibility_difference.h"
#include "engine/scene/texel_address.h"

namespace ff::bench {
namespace {

using farfield::AlphaSurface;
using scene::BvhLeaf;
using scene::BvhNode;

struct ExactRay {
    DVec3 origin, direction;
};

// Calls on_leaf(id) for the leaves whose boxes the ray meets nearer than `far`, in any order.
template <class OnLeaf>
void walk(const BvhNode* nodes, const ExactRay& ray, const double& far, OnLeaf&& on_leaf) {
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const std::uint32_t id = stack.back();
        stack.pop_back();
        if (id & scene::kBvhLeafBit) {
            on_leaf(id & ~scene::kBvhLeafBit);
            continue;
        }
        const BvhNode& node = nodes[id];
        for (int lane = 0; lane < scene::kBvhWidth; ++lane) {
            if (node.child[lane] == scene::kBvhEmpty) continue;
            const DVec3 low(node.low_x[lane], node.low_y[lane], node.low_z[lane]);
            const DVec3 high(node.high_x[lane], node.high_y[lane], node.high_z[lane]);
            double enter = 0.0, leave = far;
            for (int axis = 0; axis < 3; ++axis) {
                // Instances' boxes are floats of rounded sums.
                const double slack = 1e-6 * (1.0 + std::max(std::abs(low[axis]), std::abs(high[axis])));
                const double inverse = 1.0 / ray.direction[axis];
                const double t0 = (low[axis] - slack - ray.origin[axis]) * inverse;
                const double t1 = (high[axis] + slack - ray.origin[axis]) * inverse;
                enter = std::fmax(enter, std::fmin(t0, t1));  // what is not a number counts as met
                leave = std::fmin(leave, std::fmax(t0, t1));
            }
            if (enter <= leave) stack.push_back(node.child[lane]);
        }
    }
}

std::uint32_t texel_of(double coordinate, std::uint32_t size, scene::Wrap wrap) {
    double c = coordinate;
    if (wrap == scene::Wrap::repeat) {
        c -= std::floor(c);
    } else if (wrap == scene::Wrap::mirror) {
        c -= 2.0 * std::floor(0.5 * c);
        if (c > 1.0) c = 2.0 - c;
    }
    return std::uint32_t(std::clamp(c * size, 0.0, double(size - 1)));
}

// is_opaque_at() of alpha_test.h.
bool is_opaque(const AlphaSurface& surface, double b1, double b2, double footprint_m) {
    if (!surface.is_see_through) return true;
    const double b0 = 1.0 - b1 - b2;
    const auto mix = [&](double v0, double v1, double v2) { return v0 * b0 + v1 * b1 + v2 * b2; };
    double alpha = mix(surface.alpha[0], surface.alpha[1], surface.alpha[2]);
    std::uint32_t x = texel_of(b1, 64, scene::Wrap::clamp), y = texel_of(b2, 64, scene::Wrap::clamp);
    if (surface.texture != nullptr) {
        const scene::Texture& texture = *surface.texture;
        const double texels = std::max(footprint_m * double(surface.texels_per_m), 1.0);
        const auto level = std::uint32_t(std::min(std::ilogb(texels), int(surface.last_level)));
        const std::uint32_t width = std::max(1u, texture.width >> level);
        x = texel_of(mix(surface.uv[0].x, surface.uv[1].x, surface.uv[2].x), width, texture.wrap_u);
        y = texel_of(mix(surface.uv[0].y, surface.uv[1].y, surface.uv[2].y), std::max(1u, texture.height >> level),
                     texture.wrap_v);
        alpha *= (surface.texels[scene::level_offset(texture, level) + std::size_t(y) * width + x] >> 24) / 255.0;
    }
    return alpha >= double(surface.is_blended ? farfield::hashed_threshold(surface.seed, x, y) : surface.cutoff);
}

}  // namespace

ExactHit find_exact_hit(const scene::StaticScene& scene, const PinholeView& view, int x, int y) {
    const DVec3 direction =
        DMat3(view.world_from_camera) * DVec3((x + 0.5) * double(view.u_step) + double(view.u_first),
                                              (y + 0.5) * double(view.v_step) + double(view.v_first), -1.0);
    ExactHit hit;
    double far = std::numeric_limits<double>::infinity();
    const auto meet_instance = [&](std::uint32_t id) {
        const scene::Instance& instance = scene.instances[id];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        const DMat3 mesh_from_world = glm::inverse(DMat3(instance.world_from_mesh));
        const ExactRay ray{mesh_from_world * (view.position - instance.position), mesh_from_world * direction};
        walk(scene.mesh_nodes.data() + mesh.first_node, ray, far, [&](std::uint32_t leaf_id) {
            const BvhLeaf& leaf = scene.mesh_leaves[mesh.first_leaf + leaf_id];
            for (std::uint32_t i = 0; i < leaf.triangle_count; ++i) {
                DVec3 p[3];
                for (int k = 0; k < 3; ++k) {
                    const int v = leaf.corner[k][i];
                    p[k] = DVec3(leaf.x[v], leaf.y[v], leaf.z[v]) - ray.origin;
                }
                const double w0 = glm::dot(glm::cross(p[2], p[1]), ray.direction);
                const double w1 = glm::dot(glm::cross(p[0], p[2]), ray.direction);
                const double w2 = glm::dot(glm::cross(p[1], p[0]), ray.direction);
                const double sum = w0 + w1 + w2;
                if (sum == 0.0 || std::min({w0, w1, w2}) * std::max({w0, w1, w2}) < 0.0) continue;
                const DVec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
                const double depth = glm::dot(normal, p[0]) / glm::dot(normal, ray.direction);
                if (!(depth > 0.0 && depth < far)) continue;
                const std::uint32_t triangle = leaf.first_triangle + i;
                const AlphaSurface surface = farfield::make_alpha_surface(scene, instance, id, triangle);
                if (!is_opaque(surface, w1 / sum, w2 / sum, depth * double(view.pixel_angle()))) continue;
                far = depth;
                hit = {id, triangle, depth};
            }
        });
    };
    if (!scene.instance_nodes.empty())
        walk(scene.instance_nodes.data(), {view.position - scene.origin, direction}, far, meet_instance);
    return hit;
}

bool is_wrong(const farfield::VisibilityBuffer& answers, std::size_t at, const ExactHit& exact) {
    const bool is_sky = answers.instance[at] == farfield::kSkyInstance;
    if (is_sky || exact.instance == farfield::kSkyInstance) return is_sky != (exact.instance == farfield::kSkyInstance);
    if (answers.instance[at] == exact.instance && answers.triangle[at] == exact.triangle) return false;
    return !(std::abs(double(answers.depth[at]) - exact.depth) <= double(farfield::kTieShare) * exact.depth);
}

}  // namespace ff::bench
