// The horizon of what stands around the eye, from the boxes of the scene's BVHs: a square of the height grid that holds
// a house is as tall as the house everywhere, and would leave a street without sky.
//
// Walks the instances' BVH and the meshes' front to back, with the same test as the walk of the grid. Leaves count as
// boxes; those that look very wide from here (a diagonal wall along the street has a box that covers the street) are
// taken apart into triangles. A triangle's skyline is that of its edges; to each column an edge adds what the part of
// it that lies in the column's wedge does.
//
// The eye may be anywhere in a cylinder: to all of its places together a box looks as one that is larger by the
// cylinder does to its middle, a wedge is a strip wider on each side, and everything is nearer and higher by its radius
// and half its height.
#include "engine/farfield/horizon_near.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/horizon_near.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/farfield/horizon_columns-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Where the coordinates of a BVH lie relative to the eye, and how well they are known.
struct Placement {
    Mat3 linear;
    Vec3 offset;
    float slack_m;  ///< rounding of positions, several units in the last place
};

struct Candidate : Bound {
    std::uint32_t id;
    float distance;
};

class NearWalk {
  public:
    NearWalk(const HorizonNearInput& in, float* tangents) : in_(in), tangents_(tangents) {}

    std::uint32_t walk() {
        const scene::StaticScene& scene = *in_.scene;
        if (scene.instance_nodes.empty()) return 0;
        const Vec3 offset(scene.origin - in_.eye);
        const Vec3 size(
            glm::max(glm::abs(scene.bounds.high - scene.origin), glm::abs(scene.bounds.low - scene.origin)));
        const Placement placement{Mat3(1.0f), offset, 4e-7f * (largest(size) + largest(glm::abs(offset)))};
        walk_nodes(scene.instance_nodes.data(), placement, [&](const Candidate& leaf) { walk_instance(leaf.id); });
        return count_;
    }

  private:
    static float largest(const Vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }

    void walk_instance(std::uint32_t id) {
        const scene::StaticScene& scene = *in_.scene;
        const scene::Instance& instance = scene.instances[id];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.node_count == 0) return;
        const Mat3& m = instance.world_from_mesh;
        const Vec3 offset(instance.position - in_.eye);
        const Vec3 reach = glm::max(glm::abs(mesh.bounds.low), glm::abs(mesh.bounds.high));
        const Vec3 size = glm::abs(m[0]) * reach.x + glm::abs(m[1]) * reach.y + glm::abs(m[2]) * reach.z;
        const Placement placement{m, offset, 4e-7f * (largest(size) + largest(glm::abs(offset)))};
        const scene::BvhLeaf* const leaves = scene.mesh_leaves.data() + mesh.first_leaf;
        walk_nodes(scene.mesh_nodes.data() + mesh.first_node, placement, [&](const Candidate& leaf) {
            if (leaf.count > in_.wedges.columns / 20 && in_.wedges.near_distance == 0.0f)
                raise_triangles(leaves[leaf.id], placement);
            else
                raise(
                    in_.wedges, leaf, [] { return 0u; }, tangents_, nullptr);
        });
    }

    template <class Leaf>
    void walk_nodes(const scene::BvhNode* nodes, const Placement& placement, const Leaf& at_leaf) {
        // 15 siblings wait on each level; no BVH of a world that fits in memory is deeper.
        constexpr int kStack = 15 * 24 + 16;
        Candidate stack[kStack];
        int top = expand(nodes[0], placement, stack, 0);
        while (top > 0) {
            const Candidate candidate = stack[--top];
            if (!raises_any(in_.wedges, candidate, tangents_)) continue;
            if (candidate.id & scene::kBvhLeafBit) {
                Candidate leaf = candidate;
                leaf.id &= ~scene::kBvhLeafBit;
                at_leaf(leaf);
            } else if (top + 16 > kStack) {
                raise(
                    in_.wedges, candidate, [] { return 0u; }, tangents_,
                    nullptr);  // too deep: the box itself, still true
            } else {
                top = expand(nodes[candidate.id], placement, stack, top);
            }
        }
    }

    /// Pushes the children within reach, the nearest last.
    int expand(const scene::BvhNode& node, const Placement& placement, Candidate* stack, int top) {
        alignas(64) float rise[16], a[16], b[16], distance2[16];
        alignas(64) std::int32_t first[16], count[16];
        const Mat3& m = placement.linear;
        const V half = hn::Set(d, 0.5f), zero = hn::Zero(d), one = hn::Set(d, 1.0f);
        const Vec3 slack = Vec3(in_.roam_m, in_.climb_m, in_.roam_m) + placement.slack_m;
        std::uint32_t within = 0;
        for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
            const V lows[3] = {hn::Load(d, node.low_x + i), hn::Load(d, node.low_y + i), hn::Load(d, node.low_z + i)};
            const V highs[3] = {hn::Load(d, node.high_x + i), hn::Load(d, node.high_y + i),
                                hn::Load(d, node.high_z + i)};
            V center[3], reach[3];
            for (int axis = 0; axis < 3; ++axis) {
                center[axis] = hn::Set(d, placement.offset[axis]);
                reach[axis] = hn::Set(d, slack[axis]);
            }
            for (int k = 0; k < 3; ++k) {
                const V c = hn::Mul(hn::Add(lows[k], highs[k]), half), e = hn::Mul(hn::Sub(highs[k], lows[k]), half);
                for (int axis = 0; axis < 3; ++axis) {
                    center[axis] = hn::Add(center[axis], hn::Mul(hn::Set(d, m[k][axis]), c));
                    reach[axis] = hn::Add(reach[axis], hn::Mul(hn::Set(d, std::abs(m[k][axis])), e));
                }
            }
            Extent e;
            e.low_x = hn::Sub(center[0], reach[0]);
            e.high_x = hn::Add(center[0], reach[0]);
            e.low_z = hn::Sub(center[2], reach[2]);
            e.high_z = hn::Add(center[2], reach[2]);
            e.gap_x = hn::Max(hn::Max(e.low_x, hn::Neg(e.high_x)), zero);
            e.gap_z = hn::Max(hn::Max(e.low_z, hn::Neg(e.high_z)), zero);
            const V far_x = hn::Max(hn::Neg(e.low_x), e.high_x), far_z = hn::Max(hn::Neg(e.low_z), e.high_z);
            const V up = hn::Add(center[1], reach[1]);
            const auto above = hn::Gt(up, zero);
            hn::Store(up, d, rise + i);
            hn::Store(hn::Div(one, hn::IfThenElse(above, e.gap_x, far_x)), d, a + i);
            hn::Store(hn::Div(one, hn::IfThenElse(above, e.gap_z, far_z)), d, b + i);
            const V gap2 = hn::Add(hn::Mul(e.gap_x, e.gap_x), hn::Mul(e.gap_z, e.gap_z));
            const V far2 = hn::Add(hn::Mul(far_x, far_x), hn::Mul(far_z, far_z));
            hn::Store(gap2, d, distance2 + i);
            // Empty lanes are inf - inf = NaN and fail these comparisons.
            const auto wanted = hn::And(hn::Lt(gap2, hn::Set(d, in_.reach_m * in_.reach_m)),
                                        hn::Ge(far2, hn::Set(d, in_.wedges.near_distance * in_.wedges.near_distance)));
            std::uint8_t lanes[8] = {};
            hn::StoreMaskBits(d, wanted, lanes);
            within |= (std::uint32_t(lanes[0]) | std::uint32_t(lanes[1]) << 8) << i;
            if (lanes[0] == 0 && lanes[1] == 0) continue;
            compute_columns(in_.wedges, 4.0f, e, first + i, count + i);
        }
        const int begin = top;
        for (; within != 0; within &= within - 1) {
            const int i = std::countr_zero(within);
            if (node.child[i] == scene::kBvhEmpty) continue;
            ++count_;
            Candidate candidate;
            candidate.rise = rise[i];
            candidate.a = a[i];
            candidate.b = b[i];
            candidate.first = first[i];
            candidate.count = count[i];
            candidate.id = node.child[i];
            candidate.distance = distance2[i];
            int place = top++;
            for (; place > begin && stack[place - 1].distance < candidate.distance; --place)
                stack[place] = stack[place - 1];
            stack[place] = candidate;
        }
        return top;
    }

    void raise_all(float tangent) {
        for (int c = 0; c < in_.wedges.columns; ++c) tangents_[c] = std::max(tangents_[c], tangent);
    }

    static float cross_2d(const Vec3& a, const Vec3& b) { return a.x * b.z - a.z * b.x; }

    /// Horizontal distance from the eye to a segment.
    static float distance_to_edge(const Vec3& p, const Vec3& q) {
        const float dx = q.x - p.x, dz = q.z - p.z, length2 = dx * dx + dz * dz;
        const float s = length2 > 0.0f ? std::clamp(-(p.x * dx + p.z * dz) / length2, 0.0f, 1.0f) : 0.0f;
        const float x = p.x + s * dx, z = p.z + s * dz;
        return std::sqrt(x * x + z * z);
    }

    void raise_triangles(const scene::BvhLeaf& leaf, const Placement& placement) {
        for (int t = 0; t < leaf.triangle_count; ++t) {
            ++count_;
            Vec3 corner[3];
            for (int k = 0; k < 3; ++k) {
                const int v = leaf.corner[k][t];
                corner[k] = placement.linear * Vec3(leaf.x[v], leaf.y[v], leaf.z[v]) + placement.offset;
            }
            const float slack = 2.0f * placement.slack_m + in_.roam_m,
                        slack_up = 2.0f * placement.slack_m + in_.climb_m;
            const float top = std::max(corner[0].y, std::max(corner[1].y, corner[2].y)) + slack_up;
            float nearest = kInfinity;
            for (int k = 0; k < 3; ++k) nearest = std::min(nearest, distance_to_edge(corner[k], corner[(k + 1) % 3]));
            if (nearest <= slack) {  // an edge straight above or below the eye, as far as one can tell
                raise_all(top > 0.0f ? kInfinity : 0.0f);
                continue;
            }
            const float side[3] = {cross_2d(corner[0], corner[1]), cross_2d(corner[1], corner[2]),
                                   cross_2d(corner[2], corner[0])};
            const bool over_eye = (side[0] > 0.0f && side[1] > 0.0f && side[2] > 0.0f) ||
                                  (side[0] < 0.0f && side[1] < 0.0f && side[2] < 0.0f);
            if (over_eye && top > 0.0f) {
                // Its height there, from the barycentric weights, and the eye's distance from its plane.
                const float height = (side[1] * corner[0].y + side[2] * corner[1].y + side[0] * corner[2].y) /
                                     (side[0] + side[1] + side[2]);
                const Vec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
                const float distance = -height * std::abs(normal.y) / glm::length(normal);
                if (!(distance > slack + slack_up + 1e-4f * top)) {
                    raise_all(kInfinity);
                    continue;
                }
            }
            for (int k = 0; k < 3; ++k) raise_edge(corner[k], corner[(k + 1) % 3], slack, slack_up);
        }
    }

    void raise_edge(const Vec3& p, const Vec3& q, float slack, float slack_up) {
        const int columns = in_.wedges.columns;
        const float from = azimuth_turn(p.x, p.z);
        float turn = azimuth_turn(q.x, q.z) - from;
        turn -= std::floor(turn + 0.5f);
        // The eye's place turns positions by at most slack / distance.
        const float nearest = distance_to_edge(p, q) - slack;
        const float margin = 4.0f * in_.wedges.column_margin + float(columns) * 0.17f * slack / nearest;
        int first = int(std::floor((from + std::min(turn, 0.0f)) * float(columns) - margin));
        const int last = int(std::floor((from + std::max(turn, 0.0f)) * float(columns) + margin));
        const int count = std::min(columns, last - first + 1);
        first = (first % columns + columns) % columns;

        const float top = std::max(p.y, q.y) + slack_up;
        const float farthest = std::sqrt(std::max(p.x * p.x + p.z * p.z, q.x * q.x + q.z * q.z)) + slack;
        const Edge edge{p, q - p, slack, slack_up, nearest, farthest, top > 0.0f ? top / nearest : top / farthest};
        const int before_wrap = std::min(first + count, columns);
        raise_columns(edge, first, before_wrap);
        raise_columns(edge, 0, first + count - before_wrap);
    }

    struct Edge {
        Vec3 from, along;
        float slack, slack_up;    ///< horizontally, vertically
        float nearest, farthest;  ///< horizontally, to any of the eye's places
        float limit;              ///< no tangent is greater
    };

    void raise_columns(const Edge& edge, int first, int end) {
        const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
        const V px = hn::Set(d, edge.from.x), py = hn::Set(d, edge.from.y), pz = hn::Set(d, edge.from.z);
        const V ex = hn::Set(d, edge.along.x), ey = hn::Set(d, edge.along.y), ez = hn::Set(d, edge.along.z);
        // Half the width of the strip around a wedge: where the eye may be, the wedge's margin, rounding.
        const float margin = 7.0f * in_.wedges.column_margin / float(in_.wedges.columns) + 2e-6f;
        const V strip = hn::Set(d, -(edge.slack + margin * edge.farthest));
        const float length2 = edge.along.x * edge.along.x + edge.along.z * edge.along.z;
        const float foot_at = -(edge.from.x * edge.along.x + edge.from.z * edge.along.z) / length2;
        const V foot = hn::Set(d, length2 > 0.0f ? foot_at : 0.0f);
        const V limit = hn::Set(d, edge.limit), slack = hn::Set(d, edge.slack), nearest = hn::Set(d, edge.nearest);
        for (int c = first; c < end; c += int(hn::Lanes(d))) {
            const V old = hn::LoadU(d, tangents_ + c);
            const auto inside = hn::FirstN(d, std::size_t(end - c));
            if (hn::AllFalse(d, hn::And(hn::Lt(old, limit), inside))) continue;
            const V ax = hn::LoadU(d, in_.border_x + c), az = hn::LoadU(d, in_.border_z + c);
            const V bx = hn::LoadU(d, in_.border_x + c + 1), bz = hn::LoadU(d, in_.border_z + c + 1);
            // Of the edge, what lies clockwise of the first border, counterclockwise of the second, and not behind.
            V low = zero, high = one;
            const auto clip = [&](V at_start, V per_length) HWY_ATTR {
                const V bound = hn::Div(hn::Sub(strip, at_start), per_length);
                low = hn::IfThenElse(hn::Gt(per_length, zero), hn::Max(low, bound), low);
                high = hn::IfThenElse(hn::Lt(per_length, zero), hn::Min(high, bound), high);
            };
            const auto cross = [&](V x0, V z0, V x1, V z1)
                                   HWY_ATTR { return hn::Sub(hn::Mul(x0, z1), hn::Mul(z0, x1)); };
            clip(cross(ax, az, px, pz), cross(ax, az, ex, ez));
            clip(cross(px, pz, bx, bz), cross(ex, ez, bx, bz));
            clip(hn::MulAdd(ax, px, hn::Mul(az, pz)), hn::MulAdd(ax, ex, hn::Mul(az, ez)));
            const auto any = hn::And(hn::Le(low, high), inside);
            if (hn::AllFalse(d, any)) continue;
            const auto height_at = [&](V s) HWY_ATTR { return hn::MulAdd(ey, s, py); };
            const auto distance_at = [&](V s) HWY_ATTR {
                const V x = hn::MulAdd(ex, s, px), z = hn::MulAdd(ez, s, pz);
                return hn::Sqrt(hn::MulAdd(x, x, hn::Mul(z, z)));
            };
            const V top = hn::Add(hn::Max(height_at(low), height_at(high)), hn::Set(d, edge.slack_up));
            const V near = hn::Max(hn::Sub(distance_at(hn::Min(hn::Max(foot, low), high)), slack), nearest);
            const V far = hn::Add(hn::Max(distance_at(low), distance_at(high)), slack);
            V tangent = hn::Div(top, hn::IfThenElse(hn::Gt(top, zero), near, far));
            tangent = hn::MulAdd(hn::Add(one, hn::Abs(tangent)), hn::Set(d, 1e-5f), tangent);
            tangent = hn::IfThenElse(any, hn::Min(tangent, limit), old);
            hn::StoreU(hn::Max(tangent, old), d, tangents_ + c);
        }
    }

    const HorizonNearInput& in_;
    float* tangents_;
    std::uint32_t count_ = 0;
};

std::uint32_t walk_near(const HorizonNearInput& input, float* tangents) {
    return NearWalk(input, tangents).walk();
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
HWY_EXPORT(walk_near);
std::uint32_t trace_horizon_near(const HorizonNearInput& input, float* tangents) {
    return HWY_DYNAMIC_DISPATCH(walk_near)(input, tangents);
}
}  // namespace ff::farfield
#endif
