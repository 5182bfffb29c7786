// Single rays through the same hierarchies: for the few that no tile serves. SIMD over the children of a node and the
// triangles of a leaf.
//
// Based on: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013 (vertices sheared onto the ray;
// signs of the edge products are exact or zero, and zero counts as inside, so closed meshes have no leak).

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/beam_caster_rays.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <bit>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/beam_caster.h"
#include "engine/farfield/beam_tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

constexpr int kStackEntries = 2048;  // see beam_walk-inl.h

struct StackEntry {
    float near;
    std::uint32_t child;
};

// A ray in the space of one hierarchy.
struct LocalRay {
    Vec3 origin, direction;
    Vec3 inverse;  // of the direction; huge where it has a zero
    Vec3 slack;    // by which boxes are widened, for rounding
    int axis[3];   // axis[2] is the direction's longest
    float shear_x, shear_y, shear_z;
};

LocalRay local_ray(const DVec3& origin, const DVec3& direction, const Vec3& reach) {
    LocalRay ray;
    ray.origin = Vec3(origin);
    ray.direction = Vec3(direction);
    for (int i = 0; i < 3; ++i) {
        constexpr float huge = 1e30f;
        const float inverse = 1.0f / ray.direction[i];
        ray.inverse[i] = std::abs(inverse) < huge ? inverse : std::copysign(huge, ray.direction[i]);
        ray.slack[i] = kBoxError * (reach[i] + std::abs(ray.origin[i]));
    }
    const Vec3 size = glm::abs(ray.direction);
    ray.axis[2] = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    ray.axis[0] = (ray.axis[2] + 1) % 3;
    ray.axis[1] = (ray.axis[2] + 2) % 3;
    const float longest = ray.direction[ray.axis[2]];
    ray.shear_x = ray.direction[ray.axis[0]] / longest;
    ray.shear_y = ray.direction[ray.axis[1]] / longest;
    ray.shear_z = 1.0f / longest;
    return ray;
}

std::uint32_t children_hit(const BvhNode& node, const LocalRay& ray, float far, float* near) {
    const float* const low[3] = {node.low_x, node.low_y, node.low_z};
    const float* const high[3] = {node.high_x, node.high_y, node.high_z};
    std::uint32_t bits = 0;
    for (int i = 0; i < 16; i += kLanes) {
        VF enter = hn::Zero(f), leave = hn::Set(f, far);
        MF exists = hn::MaskFromVec(hn::Zero(f));
        for (int a = 0; a < 3; ++a) {
            const VF origin = hn::Set(f, ray.origin[a]), inverse = hn::Set(f, ray.inverse[a]);
            const VF slack = hn::Set(f, ray.slack[a]);
            const VF low_side = hn::Load(f, low[a] + i), high_side = hn::Load(f, high[a] + i);
            const VF t0 = hn::Mul(hn::Sub(hn::Sub(low_side, slack), origin), inverse);
            const VF t1 = hn::Mul(hn::Sub(hn::Add(high_side, slack), origin), inverse);
            enter = hn::Max(enter, hn::Min(t0, t1));
            leave = hn::Min(leave, hn::Max(t0, t1));
            exists = hn::Le(low_side, high_side);
        }
        enter = hn::Mul(enter, hn::Set(f, 0.999999f));
        hn::Store(enter, f, near + i);
        const MF hit = hn::Le(enter, hn::Mul(leave, hn::Set(f, 1.000001f)));
        bits |= bits_of(hn::And(exists, hit)) << i;
    }
    return bits;
}

template <class OnLeaf>
void walk(const BvhNode* nodes, const LocalRay& ray, const float& far, std::uint64_t& visited, OnLeaf&& on_leaf) {
    StackEntry stack[kStackEntries];
    int top = 0;
    stack[top++] = {0.0f, 0};
    while (top > 0) {
        const StackEntry entry = stack[--top];
        if (!(entry.near <= far)) continue;
        if (entry.child & kBvhLeafBit) {
            on_leaf(entry.child & ~kBvhLeafBit);
            continue;
        }
        const BvhNode& node = nodes[entry.child];
        ++visited;
        alignas(64) float near[16];
        std::uint32_t bits = children_hit(node, ray, far, near);
        if (top + scene::kBvhWidth > kStackEntries) continue;  // no tree of ours is that deep
        const int bottom = top;
        for (; bits != 0; bits &= bits - 1) {
            const int lane = std::countr_zero(bits);
            const StackEntry child{near[lane], node.child[lane]};
            int at = top++;
            for (; at > bottom && stack[at - 1].near < child.near; --at) stack[at] = stack[at - 1];
            stack[at] = child;
        }
    }
}

void intersect_leaf(const scene::StaticScene& scene, const BvhLeaf& leaf, const LocalRay& ray, std::uint32_t instance,
                    RayHit& hit) {
    // Vertices relative to the origin, sheared so that the ray is the z axis.
    alignas(64) float x[32], y[32], z[32];
    const float* const lanes[3] = {leaf.x, leaf.y, leaf.z};
    for (int v = 0; v < leaf.vertex_count; v += kLanes) {
        const auto relative = [&](int a) {
            return hn::Sub(hn::Load(f, lanes[ray.axis[a]] + v), hn::Set(f, ray.origin[ray.axis[a]]));
        };
        const VF rz = relative(2);
        hn::Store(hn::Sub(relative(0), hn::Mul(hn::Set(f, ray.shear_x), rz)), f, x + v);
        hn::Store(hn::Sub(relative(1), hn::Mul(hn::Set(f, ray.shear_y), rz)), f, y + v);
        hn::Store(hn::Mul(hn::Set(f, ray.shear_z), rz), f, z + v);
    }
    alignas(64) float corner[9][16];
    for (int i = 0; i < BvhLeaf::kMaxTriangles; ++i) {
        for (int k = 0; k < 3; ++k) {
            const int v = leaf.corner[k][i];
            corner[3 * k][i] = x[v];
            corner[3 * k + 1][i] = y[v];
            corner[3 * k + 2][i] = z[v];
        }
    }
    for (int first = 0; first < leaf.triangle_count; first += kLanes) {
        const auto load = [&](int row) { return hn::Load(f, corner[row] + first); };
        const VF ax = load(0), ay = load(1), az = load(2), bx = load(3), by = load(4), bz = load(5);
        const VF cx = load(6), cy = load(7), cz = load(8);
        const VF u = hn::Sub(hn::Mul(cx, by), hn::Mul(cy, bx));
        const VF v = hn::Sub(hn::Mul(ax, cy), hn::Mul(ay, cx));
        const VF w = hn::Sub(hn::Mul(bx, ay), hn::Mul(by, ax));
        const VF zero = hn::Zero(f);
        const VF least = hn::Min(u, hn::Min(v, w)), most = hn::Max(u, hn::Max(v, w));
        const VF det = hn::Add(u, hn::Add(v, w));
        const VF t = hn::Div(hn::MulAdd(u, az, hn::MulAdd(v, bz, hn::Mul(w, cz))), det);
        // A zero determinant gives inf or not-a-number, which no comparison lets through.
        MF found = hn::And(hn::Or(hn::Ge(least, zero), hn::Le(most, zero)), hn::Ne(det, zero));
        found = hn::And(found, hn::And(hn::Ge(t, zero), hn::Le(t, hn::Set(f, hit.t))));
        std::uint32_t bits = bits_of(found);
        if (leaf.triangle_count - first < kLanes) bits &= (1u << (leaf.triangle_count - first)) - 1u;
        if (bits == 0) continue;
        alignas(64) float ts[16], vs[16], ws[16];
        hn::Store(t, f, ts);
        hn::Store(hn::Div(v, det), f, vs);
        hn::Store(hn::Div(w, det), f, ws);
        for (; bits != 0; bits &= bits - 1) {
            const int lane = std::countr_zero(bits), i = first + lane;
            const std::uint32_t triangle = leaf.first_triangle + std::uint32_t(i);
            const bool wins = ts[lane] < hit.t ||
                              (ts[lane] == hit.t &&
                               (instance < hit.instance || (instance == hit.instance && triangle < hit.triangle)));
            if (!wins || !(ts[lane] < std::numeric_limits<float>::infinity())) continue;
            if ((leaf.alpha_triangles >> i) & 1) {
                const AlphaSurface surface = make_alpha_surface(scene, scene.instances[instance], instance, triangle);
                if (!is_opaque_at(surface, vs[lane], ws[lane], 0.0f)) continue;
            }
            hit = {instance, triangle, ts[lane]};
        }
    }
}

}  // namespace

RayHit CastRay(const scene::StaticScene& scene, const Ray& ray, CastCost& cost) {
    RayHit hit{kSkyInstance, 0, std::numeric_limits<float>::infinity()};
    ++cost.rays;
    const DVec3 direction(ray.direction);
    const double check = glm::dot(direction, direction) + glm::dot(ray.origin, ray.origin);
    if (!std::isfinite(check) || direction == DVec3(0.0) || scene.instance_nodes.empty()) return hit;
    const auto reach_of = [](const Vec3& low, const Vec3& high) { return glm::max(glm::abs(low), glm::abs(high)); };
    const Vec3 reach = reach_of(Vec3(scene.bounds.low - scene.origin), Vec3(scene.bounds.high - scene.origin));
    const LocalRay world_ray = local_ray(ray.origin - scene.origin, direction, reach);
    walk(scene.instance_nodes.data(), world_ray, hit.t, cost.nodes, [&](std::uint32_t id) {
        const scene::Instance& instance = scene.instances[id];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        const DMat3 mesh_from_world = glm::inverse(DMat3(instance.world_from_mesh));
        const LocalRay mesh_ray = local_ray(mesh_from_world * (ray.origin - instance.position),
                                            mesh_from_world * direction, reach_of(mesh.bounds.low, mesh.bounds.high));
        walk(scene.mesh_nodes.data() + mesh.first_node, mesh_ray, hit.t, cost.nodes, [&](std::uint32_t id_in_mesh) {
            const BvhLeaf& leaf = scene.mesh_leaves[mesh.first_leaf + id_in_mesh];
            cost.triangles += leaf.triangle_count;
            intersect_leaf(scene, leaf, mesh_ray, id, hit);
        });
    });
    return hit;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::beam {
HWY_EXPORT(CastRay);

RayHit cast_ray(const scene::StaticScene& scene, const Ray& ray, CastCost& cost) {
    return HWY_DYNAMIC_DISPATCH(CastRay)(scene, ray, cost);
}
}  // namespace ff::farfield::beam
#endif
