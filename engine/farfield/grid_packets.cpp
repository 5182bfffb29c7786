// Packets of one viewer's rays, slice by slice.

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/grid_traversal.h"
#include "engine/farfield/grid_triangle.h"
#include "engine/farfield/tile_regroup.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/grid_packets.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::grid {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kWidth = 16;
constexpr float kInf = std::numeric_limits<float>::infinity();
/// Cells by which a packet's outline is taken wider than computed: above the rounding of positions within a grid.
constexpr float kSlack = 1e-3f;

using DF = hn::CappedTag<float, kWidth>;
using DU = hn::RebindToUnsigned<DF>;

/// Directions of a packet in some space; all start at one origin.
struct Directions {
    alignas(64) float axis[3][kWidth];
};

struct Packet {
    Directions world;
    alignas(64) float t[kWidth];  ///< nearest hit so far
    alignas(64) std::uint32_t instance[kWidth];
    alignas(64) std::uint32_t triangle[kWidth];
    std::uint32_t lanes = 0;  ///< bits of the lanes in use
};

/// The beam that a packet forms in a grid: cells along the main axis as the running coordinate w >= 0, and the others
/// as origin + slope * w with the slopes of its outermost rays.
struct Beam {
    int main, side[2];
    bool forward;  ///< along growing coordinates of the main axis
    float start;   ///< origin on the main axis, cells, counted in the beam's direction
    float origin[2];
    float low[2], high[2];  ///< slopes
    float w_enter, w_leave;
    float most_cells_per_t;
};

/// @return false: the packet misses the grid. `splits` is set where its rays do not share a main direction.
bool make_beam(const Grid& grid, const Vec3& origin, const Directions& d, Beam& beam, bool& splits) {
    splits = false;
    if (grid.count[0] == 0) return false;
    const DF df;
    // The main axis is the fastest of the middle lane's; all must go along it the same way.
    int main = 0;
    float fastest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float speed = std::fabs(d.axis[axis][kWidth / 2] * grid.cells_per_m[axis]);
        if (speed > fastest) fastest = speed, main = axis;
    }
    const auto range_of = [&](auto&& value) {
        auto low = hn::Set(df, kInf), high = hn::Set(df, -kInf);
        for (std::size_t lane = 0; lane < kWidth; lane += hn::Lanes(df)) {
            const auto v = value(lane);
            low = hn::Min(low, v);
            high = hn::Max(high, v);
        }
        return std::pair(hn::GetLane(hn::MinOfLanes(df, low)), hn::GetLane(hn::MaxOfLanes(df, high)));
    };
    const auto [slow, quick] = range_of([&](std::size_t lane) { return hn::Load(df, d.axis[main] + lane); });
    if (!(slow > 0 || quick < 0)) {
        splits = true;
        return false;
    }
    beam.main = main;
    beam.side[0] = (main + 1) % 3;
    beam.side[1] = (main + 2) % 3;
    beam.forward = slow > 0;
    const float size = float(grid.count[main]);
    const float o = (origin[main] - grid.low[main]) * grid.cells_per_m[main];
    beam.start = beam.forward ? o : size - o;
    beam.most_cells_per_t = std::max(std::fabs(slow), std::fabs(quick)) * grid.cells_per_m[main];
    beam.w_enter = std::max(0.0f, -beam.start);
    beam.w_leave = size - beam.start;
    for (int k = 0; k < 2; ++k) {
        const int axis = beam.side[k];
        const float scale = grid.cells_per_m[axis] / grid.cells_per_m[main];
        const auto [low, high] = range_of([&](std::size_t lane) {
            return hn::Div(hn::Load(df, d.axis[axis] + lane), hn::Abs(hn::Load(df, d.axis[main] + lane)));
        });
        beam.low[k] = low * scale;
        beam.high[k] = high * scale;
        beam.origin[k] = (origin[axis] - grid.low[axis]) * grid.cells_per_m[axis];
        // Where the beam is beside the grid on this axis, from when and until when.
        const float end = float(grid.count[axis]) + kSlack, below = -kSlack - beam.origin[k];
        const float above = end - beam.origin[k];
        if (below > 0) {
            if (!(beam.high[k] > 0)) return false;
            beam.w_enter = std::max(beam.w_enter, below / beam.high[k]);
        } else if (above < 0) {
            if (!(beam.low[k] < 0)) return false;
            beam.w_enter = std::max(beam.w_enter, above / beam.low[k]);
        }
        if (beam.low[k] > 0) beam.w_leave = std::min(beam.w_leave, above / beam.low[k]);
        if (beam.high[k] < 0) beam.w_leave = std::min(beam.w_leave, below / beam.high[k]);
    }
    return beam.w_enter <= beam.w_leave;
}

/// Calls visit(cell) for all cells with items that the beam meets, slice after slice; limit_t() is the t beyond which
/// no ray of the packet wants anything.
template <class Limit, class Visit>
void walk_slices(const Grid& grid, const Beam& beam, CastCost& cost, Limit&& limit_t, Visit&& visit) {
    const int slices = grid.count[beam.main];
    const float steepest = std::max(
        {1.0f, std::fabs(beam.low[0]), std::fabs(beam.high[0]), std::fabs(beam.low[1]), std::fabs(beam.high[1])});
    int slice = std::clamp(int(std::floor(beam.start + beam.w_enter - kSlack)), 0, slices - 1);
    const std::size_t strides[3] = {1, std::size_t(grid.count[0]),
                                    std::size_t(grid.count[0]) * std::size_t(grid.count[1])};
    while (slice < slices) {
        const float w0 = std::max(0.0f, float(slice) - beam.start), w1 = std::max(0.0f, float(slice + 1) - beam.start);
        if (w0 > beam.w_leave || w0 > limit_t() * beam.most_cells_per_t) return;
        int low[2], high[2];
        for (int k = 0; k < 2; ++k) {
            const float a = std::min(beam.low[k] * w0, beam.low[k] * w1) + beam.origin[k] - kSlack;
            const float b = std::max(beam.high[k] * w0, beam.high[k] * w1) + beam.origin[k] + kSlack;
            const int last = grid.count[beam.side[k]] - 1;
            low[k] = std::clamp(int(std::floor(a)), 0, last);
            high[k] = std::clamp(int(std::floor(b)), 0, last);
        }
        const int along = beam.forward ? slice : slices - 1 - slice;
        const std::size_t base = strides[beam.main] * std::size_t(along);
        int clearance = 255;
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i) {
                const std::size_t cell =
                    base + strides[beam.side[0]] * std::size_t(i) + strides[beam.side[1]] * std::size_t(j);
                ++cost.nodes;
                clearance = std::min(clearance, int(grid.clearance[cell]));
                if (grid.clearance[cell] == 0) visit(cell);
            }
        // Whatever is within the clearance is empty; a beam that leans far may come there from the side.
        slice += 1 + std::max(0, int(float(clearance - 1) / steepest));
    }
}

/// Remembers what the packet has met of late. A collision only costs a second test.
struct Mailbox {
    static constexpr std::uint32_t kSize = 64;
    std::uint32_t ids[kSize];
    Mailbox() { std::fill(std::begin(ids), std::end(ids), kSkyInstance); }
    bool is_new(std::uint32_t id) {
        std::uint32_t& entry = ids[(id ^ (id >> 6)) % kSize];
        if (entry == id) return false;
        entry = id;
        return true;
    }
};

class PacketCaster {
  public:
    PacketCaster(const GridWorld& world, const PinholeView& view, VisibilityBuffer& out)
        : world_(world), view_(view), out_(out), origin_(view.position - world.scene.origin) {
        is_sane_ = std::isfinite(origin_.x + origin_.y + origin_.z);
    }
    CastCost cost;

    void cast(const PixelPacket<kWidth>& pixels) {
        cost.rays += std::uint64_t(pixels.count);
        Packet packet;
        packet.lanes = (1u << pixels.count) - 1u;
        bool is_sane = is_sane_;
        for (int lane = 0; lane < kWidth; ++lane) {
            const Vec3 d = view_.direction(int(pixels.x[lane]), int(pixels.y[lane]));
            is_sane &= std::isfinite(d.x + d.y + d.z);
            for (int axis = 0; axis < 3; ++axis) packet.world.axis[axis][lane] = d[axis];
            packet.t[lane] = kInf;
            packet.instance[lane] = kSkyInstance;
            packet.triangle[lane] = 0;
        }
        if (is_sane) trace(packet, pixels);
        for (int lane = 0; lane < pixels.count; ++lane) {
            const std::size_t at = out_.index(int(pixels.x[lane]), int(pixels.y[lane]));
            out_.instance[at] = packet.instance[lane];
            out_.triangle[at] = packet.triangle[lane];
            out_.depth[at] = packet.t[lane];
        }
    }

  private:
    void trace(Packet& packet, const PixelPacket<kWidth>& pixels) {
        Beam beam;
        bool splits = false;
        const bool meets = make_beam(world_.top, origin_, packet.world, beam, splits);
        limit_ = kInf;
        if (splits) split(packet, pixels);
        if (!meets) return;
        Mailbox instances;
        bool must_split = false;
        walk_slices(
            world_.top, beam, cost, [&] { return limit_; },
            [&](std::size_t cell) {
                for (std::uint32_t i = world_.top.first_item[cell]; i < world_.top.first_item[cell + 1]; ++i)
                    if (instances.is_new(world_.top.items[i])) must_split |= !enter(packet, world_.top.items[i]);
            });
        if (must_split) split(packet, pixels);
    }

    /// @return false: the rays part in this mesh's grid.
    bool enter(Packet& packet, std::uint32_t id) {
        const scene::Instance& instance = world_.scene.instances[id];
        const Placement& placement = world_.placements[id];
        const Grid& grid = world_.meshes[instance.mesh];
        Vec3 origin(view_.position - instance.position);
        const Directions* directions = &packet.world;
        if (placement.is_turned) {
            const Mat3& m = placement.mesh_from_world;
            origin = m * origin;
            const DF df;
            for (std::size_t lane = 0; lane < kWidth; lane += hn::Lanes(df)) {
                const auto x = hn::Load(df, packet.world.axis[0] + lane);
                const auto y = hn::Load(df, packet.world.axis[1] + lane);
                const auto z = hn::Load(df, packet.world.axis[2] + lane);
                for (int axis = 0; axis < 3; ++axis)
                    hn::Store(hn::MulAdd(hn::Set(df, m[0][axis]), x,
                                         hn::MulAdd(hn::Set(df, m[1][axis]), y, hn::Mul(hn::Set(df, m[2][axis]), z))),
                              df, turned_.axis[axis] + lane);
            }
            directions = &turned_;
        }
        Beam beam;
        bool splits = false;
        if (!make_beam(grid, origin, *directions, beam, splits)) return !splits;
        Mailbox triangles;
        walk_slices(
            grid, beam, cost, [&] { return limit_; },
            [&](std::size_t cell) {
                for (std::uint32_t k = grid.first_item[cell]; k < grid.first_item[cell + 1]; ++k)
                    if (triangles.is_new(grid.items[k])) test(packet, *directions, origin, id, instance, grid.items[k]);
            });
        return true;
    }

    void test(Packet& packet, const Directions& directions, const Vec3& origin, std::uint32_t id,
              const scene::Instance& instance, std::uint32_t triangle) {
        const DF df;
        const DU du;
        ++cost.triangles;
        const scene::StaticScene& scene = world_.scene;
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        const std::uint32_t* corner = &scene.indices[3 * (std::size_t(mesh.first_triangle) + triangle)];
        const Vec3* positions = scene.positions.data() + mesh.first_vertex;
        const Vec3 a = positions[corner[0]] - origin, b = positions[corner[1]] - origin;
        const Vec3 c = positions[corner[2]] - origin;
        const Vec3 at_a = glm::cross(c, b), at_b = glm::cross(a, c), at_c = glm::cross(b, a);
        const Vec3 normal = glm::cross(b - a, c - a);
        const float distance = glm::dot(a, normal);
        const bool see_through = (mesh.material_flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) != 0;
        const float volume_error = volume_rounding(a, b, c);
        bool any = false;
        for (std::size_t lane = 0; lane < kWidth; lane += hn::Lanes(df)) {
            const auto x = hn::Load(df, directions.axis[0] + lane);
            const auto y = hn::Load(df, directions.axis[1] + lane);
            const auto z = hn::Load(df, directions.axis[2] + lane);
            // The same three products in the same order for every triangle: neighbours get opposite numbers for
            // the edge they share.
            const auto dot = [&](const Vec3& v) {
                return hn::Add(hn::Add(hn::Mul(x, hn::Set(df, v.x)), hn::Mul(y, hn::Set(df, v.y))),
                               hn::Mul(z, hn::Set(df, v.z)));
            };
            const auto va = dot(at_a), vb = dot(at_b), vc = dot(at_c);
            const auto zero = hn::Zero(df);
            const auto least = hn::Min(va, hn::Min(vb, vc)), most = hn::Max(va, hn::Max(vb, vc));
            const auto longest = hn::Max(hn::Abs(x), hn::Max(hn::Abs(y), hn::Abs(z)));
            const auto rounding = hn::Mul(hn::Set(df, volume_error), longest);
            const auto outside = hn::And(hn::Lt(least, hn::Neg(rounding)), hn::Gt(most, rounding));
            if (hn::AllTrue(df, outside)) continue;
            const auto volume = hn::Add(hn::Add(va, vb), vc);
            auto t = hn::Div(hn::Set(df, distance), dot(normal));
            const auto inside = hn::Or(hn::Gt(least, rounding), hn::Lt(most, hn::Neg(rounding)));
            const auto doubtful = hn::AndNot(outside, hn::Not(inside));
            if (HWY_UNLIKELY(!hn::AllFalse(df, doubtful))) {
                alignas(64) float at[kWidth], in_doubt[kWidth];
                hn::Store(t, df, at);
                hn::Store(hn::IfThenElse(doubtful, hn::Set(df, 1.0f), zero), df, in_doubt);
                for (std::size_t i = 0; i < hn::Lanes(df); ++i) {
                    if (in_doubt[i] == 0.0f) continue;
                    const Vec3 d(directions.axis[0][lane + i], directions.axis[1][lane + i],
                                 directions.axis[2][lane + i]);
                    at[i] = float(
                        meet_in_double({positions[corner[0]], positions[corner[1]], positions[corner[2]]}, origin, d));
                }
                t = hn::Load(df, at);
            }
            const auto nearest = hn::Load(df, packet.t + lane);
            auto hit = hn::And(hn::Not(outside), hn::And(hn::Ge(t, zero), hn::Lt(t, nearest)));
            if (see_through) hit = hn::And(hit, hn::Ne(volume, zero));  // else no place on it could be looked up
            if (hn::AllFalse(df, hit)) continue;
            if (see_through) {
                alignas(64) float b1[kWidth], b2[kWidth], at[kWidth], opaque[kWidth];
                hn::Store(hn::Div(vb, volume), df, b1);
                hn::Store(hn::Div(vc, volume), df, b2);
                hn::Store(t, df, at);
                hn::Store(hn::VecFromMask(df, hit), df, opaque);
                const AlphaSurface surface = make_alpha_surface(scene, instance, id, triangle);
                const float pixel_angle = view_.pixel_angle();
                for (std::size_t i = 0; i < hn::Lanes(df); ++i) {
                    if (std::bit_cast<std::uint32_t>(opaque[i]) == 0) continue;
                    const bool in_layer = is_in_layer(surface, at[i], layer_depth(packet, int(lane + i)));
                    const SwayPlace place{&view_.sway, at[i] * world_direction(packet, int(lane + i))};
                    opaque[i] = is_opaque_at(surface, b1[i], b2[i], pixel_angle * at[i], in_layer, place) ? 1.0f : 0.0f;
                }
                hit = hn::Gt(hn::Load(df, opaque), zero);
                if (hn::AllFalse(df, hit)) continue;
            }
            any = true;
            hn::Store(hn::IfThenElse(hit, t, nearest), df, packet.t + lane);
            const auto hit_u = hn::RebindMask(du, hit);
            hn::Store(hn::IfThenElse(hit_u, hn::Set(du, id), hn::Load(du, packet.instance + lane)), du,
                      packet.instance + lane);
            hn::Store(hn::IfThenElse(hit_u, hn::Set(du, triangle), hn::Load(du, packet.triangle + lane)), du,
                      packet.triangle + lane);
        }
        if (!any) return;
        auto far = hn::Load(df, packet.t);
        for (std::size_t lane = hn::Lanes(df); lane < kWidth; lane += hn::Lanes(df))
            far = hn::Max(far, hn::Load(df, packet.t + lane));
        limit_ = hn::GetLane(hn::MaxOfLanes(df, far));
    }

    /// Depth before which blended hits are transparent layers (alpha_test.h).
    [[nodiscard]] float layer_depth(const Packet& packet, int lane) const {
        return view_.blend_within_m / glm::length(world_direction(packet, lane));
    }

    [[nodiscard]] static Vec3 world_direction(const Packet& packet, int lane) {
        const Directions& d = packet.world;
        return {d.axis[0][lane], d.axis[1][lane], d.axis[2][lane]};
    }

    /// Rays that part go on alone.
    void split(Packet& packet, const PixelPacket<kWidth>& pixels) {
        for (int lane = 0; lane < pixels.count; ++lane) {
            const Vec3 d(packet.world.axis[0][lane], packet.world.axis[1][lane], packet.world.axis[2][lane]);
            CastCost one;
            const RayHit hit = cast_ray(world_, {view_.position, d},
                                        {view_.pixel_angle(), layer_depth(packet, lane), &view_.sway}, one);
            cost.nodes += one.nodes;
            cost.triangles += one.triangles;
            packet.instance[lane] = hit.instance;
            packet.triangle[lane] = hit.triangle;
            packet.t[lane] = hit.t;
        }
    }

    const GridWorld& world_;
    const PinholeView& view_;
    VisibilityBuffer& out_;
    Vec3 origin_;
    Directions turned_;
    float limit_ = kInf;  ///< farthest of the packet's hits so far
    bool is_sane_ = true;
};

CastCost CastGridPackets(const GridWorld& world, const PinholeView& view, std::span<const TileRequest> tiles,
                         VisibilityBuffer& out) {
    PacketCaster caster(world, view, out);
    regroup<kWidth, 4>(
        tiles, view.width, view.height,
        [&](std::uint32_t x, std::uint32_t y, std::uint32_t mask) {
            PixelPacket<kWidth> pixels;
            for (std::uint32_t left = mask; left != 0; left &= left - 1) {
                const auto bit = std::uint32_t(std::countr_zero(left));
                pixels.x[pixels.count] = x + (bit & 3u);
                pixels.y[pixels.count++] = y + (bit >> 2);
            }
            for (int lane = pixels.count; lane < kWidth; ++lane) {
                pixels.x[lane] = pixels.x[pixels.count - 1];
                pixels.y[lane] = pixels.y[pixels.count - 1];
            }
            caster.cast(pixels);
        },
        [&](const PixelPacket<kWidth>& pixels) { caster.cast(pixels); });
    return caster.cost;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::grid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::grid {
HWY_EXPORT(CastGridPackets);
CastCost cast_packets(const GridWorld& world, const PinholeView& view, std::span<const TileRequest> tiles,
                      VisibilityBuffer& out) {
    return HWY_DYNAMIC_DISPATCH(CastGridPackets)(world, view, tiles, out);
}
}  // namespace ff::farfield::grid
#endif
