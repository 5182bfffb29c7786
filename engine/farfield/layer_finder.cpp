// A tile's beam through the hierarchies' blended parts. It begins with the depths that are seen, or the distance within
// which surfaces are blended, as if something were found there already; every layer is kept, and an opaque one moves a
// pixel's end nearer, as a hit of the tile caster does.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/layer_finder.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>

#include "engine/farfield/beam_rows-inl.h"
#include "engine/farfield/beam_walk-inl.h"
#include "engine/farfield/layer_finder.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

// A blended triangle, looked up once one of its pixels may have it as a layer.
struct LayerSurface {
    AlphaSurface alpha;
    float plane = 0.0f;      // distance of its plane from the eye, metres
    float footprint = 0.0f;  // texture areas under a pixel = this * (1 + u^2 + v^2) / slope^3.5, as in the shading pass

    LayerSurface(const scene::StaticScene& scene, std::uint32_t instance_id, std::uint32_t triangle,
                 const Vec3 (&corners)[3], const PinholeView& view) {
        const scene::Instance& instance = scene.instances[instance_id];
        alpha = make_alpha_surface(scene, instance, instance_id, triangle, corners);
        const DMat3 world_from_mesh(instance.world_from_mesh);
        const DVec3 offset = instance.position - view.position;
        DVec3 p[3];
        for (int k = 0; k < 3; ++k) p[k] = world_from_mesh * DVec3(corners[k]) + offset;
        const DVec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        const double length = std::max(glm::length(normal), 1e-30);
        const double distance = std::abs(glm::dot(normal, p[0])) / length;
        const Vec2 a = alpha.uv[1] - alpha.uv[0], b = alpha.uv[2] - alpha.uv[0];
        const double density = std::abs(double(a.x) * b.y - double(a.y) * b.x) / length;
        const double width = distance * view.pixel_angle();
        plane = float(std::max(distance, 1e-12));
        footprint = float(width * width * density);
    }
};

HWY_INLINE VF mix(VF a, VF b, VF t) {
    return hn::MulAdd(t, hn::Sub(b, a), a);
}

// The texture's alpha in the lanes of `win`, [0, 1], filtered as the shading pass filters its colour.
HWY_INLINE VF filtered_alpha(const AlphaSurface& surface, MF win, VF u, VF v, VF footprint) {
    const scene::Texture& texture = *surface.texture;
    // level = round(log2(texels under the pixel) / 2)
    const VF texels = hn::Mul(footprint, hn::Set(f, float(texture.width) * float(texture.height)));
    const VI exponent = hn::Sub(hn::ShiftRight<23>(hn::BitCast(si, texels)), hn::Set(si, 126));
    const VI last = hn::Set(si, std::int32_t(texture.level_count) - 1);
    const VI levels = hn::Min(hn::Max(hn::ShiftRight<1>(exponent), hn::Zero(si)), last);
    alignas(64) std::int32_t level_of[16];
    hn::Store(levels, si, level_of);
    VF alpha = hn::Zero(f);
    // Mostly all pixels are on one level.
    for (std::uint32_t left = bits_of(win); left != 0;) {
        const std::int32_t level = level_of[std::countr_zero(left)];
        const MF here = hn::RebindMask(f, hn::Eq(levels, hn::Set(si, level)));
        left &= ~bits_of(here);
        const auto width = std::int32_t(std::max(1u, texture.width >> level));
        const auto height = std::int32_t(std::max(1u, texture.height >> level));
        const Taps x = taps_along(u, width, texture.wrap_u), y = taps_along(v, height, texture.wrap_v);
        const std::uint32_t* first = surface.texels + scene::level_offset(texture, std::uint32_t(level));
        const VI upper = hn::Mul(y.first, hn::Set(si, width)), lower = hn::Mul(y.second, hn::Set(si, width));
        const VF above =
            mix(alpha_of(first, hn::Add(upper, x.first)), alpha_of(first, hn::Add(upper, x.second)), x.weight);
        const VF below =
            mix(alpha_of(first, hn::Add(lower, x.first)), alpha_of(first, hn::Add(lower, x.second)), x.weight);
        alpha = hn::IfThenElse(here, mix(above, below, y.weight), alpha);
    }
    return hn::Mul(alpha, hn::Set(f, 1.0f / 255.0f));
}

// Coverage in the lanes of `win`. e: their edge functions; length2: squared ratio of distance to depth.
HWY_NOINLINE VF coverage(const LayerSurface& surface, MF win, const LeafScratch& s, int i, const VF (&e)[3],
                         VF inverse_depth, VF length2) {
    const AlphaSurface& at = surface.alpha;
    const VF w0 = hn::Mul(e[0], hn::Set(f, s.weight[0][i])), w1 = hn::Mul(e[1], hn::Set(f, s.weight[1][i]));
    const VF w2 = hn::Mul(e[2], hn::Set(f, s.weight[2][i]));
    const VF inverse_sum = hn::Div(hn::Set(f, 1.0f), hn::Add(w0, hn::Add(w1, w2)));
    const VF b1 = hn::Mul(w1, inverse_sum), b2 = hn::Mul(w2, inverse_sum);
    const auto interpolate = [&](float v0, float v1, float v2) HWY_ATTR {
        return hn::MulAdd(b1, hn::Set(f, v1 - v0), hn::MulAdd(b2, hn::Set(f, v2 - v0), hn::Set(f, v0)));
    };
    const VF alpha = interpolate(at.alpha[0], at.alpha[1], at.alpha[2]);
    if (at.texture == nullptr) return alpha;
    const VF u = interpolate(at.uv[0].x, at.uv[1].x, at.uv[2].x);
    const VF v = interpolate(at.uv[0].y, at.uv[1].y, at.uv[2].y);
    const VF slope = hn::Mul(hn::Set(f, surface.plane), inverse_depth);
    const VF slope2 = hn::Mul(slope, slope);
    const VF power = hn::Max(hn::Mul(hn::Mul(slope2, slope), hn::Sqrt(slope)), hn::Set(f, 1e-30f));
    const VF footprint = hn::Div(hn::Mul(length2, hn::Set(f, surface.footprint)), power);
    return hn::Mul(alpha, filtered_alpha(at, win, u, v, footprint));
}

// Where layers go.
struct Found {
    std::span<Layer> out;
    int first_column, first_row;  // of the request, within the square
    std::size_t count = 0;
};

// Edges that two triangles share belong to the one of them whose edge function grows to the right, or downwards.
HWY_INLINE MF owns_edge(VF a, VF b) {
    const VF zero = hn::Zero(f);
    return hn::Or(hn::Gt(a, zero), hn::And(hn::Eq(a, zero), hn::Gt(b, zero)));
}

// Enters the pixels that triangle i of the leaf lies before.
HWY_INLINE void collect(const scene::StaticScene& scene, const BeamView& view, const AlphaRays& rays,
                        const BvhLeaf& leaf, const LeafScratch& s, int i, std::uint32_t instance,
                        std::uint32_t first_id, Tile& tile, Found& found) {
    const std::uint32_t triangle = leaf.first_triangle + std::uint32_t(i);
    const VF a0 = hn::Set(f, s.a[0][i]), a1 = hn::Set(f, s.a[1][i]), a2 = hn::Set(f, s.a[2][i]);
    const VF b0 = hn::Set(f, s.b[0][i]), b1 = hn::Set(f, s.b[1][i]), b2 = hn::Set(f, s.b[2][i]);
    const VF c0 = hn::Set(f, s.c[0][i]), c1 = hn::Set(f, s.c[1][i]), c2 = hn::Set(f, s.c[2][i]);
    const MF owns0 = owns_edge(a0, b0), owns1 = owns_edge(a1, b1), owns2 = owns_edge(a2, b2);
    const VF gx = hn::Set(f, s.gx[i]), gy = hn::Set(f, s.gy[i]), g0 = hn::Set(f, s.g0[i]);
    const VF low = hn::Set(f, s.low[i]), high = hn::Set(f, s.high[i]), zero = hn::Zero(f);
    const auto is_inside = [&](VF e, MF owns)
                               HWY_ATTR { return hn::Or(hn::Gt(e, zero), hn::And(owns, hn::Eq(e, zero))); };
    const LayerSurface* surface = nullptr;
    alignas(LayerSurface) std::byte room[sizeof(LayerSurface)];
    for (int row = s.y0[i]; row <= s.y1[i]; ++row) {
        const VF y = hn::Set(f, float(row) - kHalf);
        const VF r0 = hn::MulAdd(b0, y, c0), r1 = hn::MulAdd(b1, y, c1), r2 = hn::MulAdd(b2, y, c2);
        const VF rg = hn::MulAdd(gy, y, g0);
        for (int chunk = s.x0[i] / kLanes * kLanes; chunk <= s.x1[i]; chunk += kLanes) {
            const VF x = hn::Iota(f, float(chunk) - kHalf);
            const VF e[3] = {hn::MulAdd(a0, x, r0), hn::MulAdd(a1, x, r1), hn::MulAdd(a2, x, r2)};
            // Not-a-number (a sliver's plane) becomes `low`: x86's max returns its second operand then.
            const VF inverse_depth = hn::Min(hn::Max(hn::MulAdd(gx, x, rg), low), high);
            float* best_at = tile.best + row * kRowStride + chunk;
            const VF best = hn::Load(f, best_at);
            const MF inside = hn::And(is_inside(e[0], owns0), hn::And(is_inside(e[1], owns1), is_inside(e[2], owns2)));
            const MF before = hn::And(inside, hn::Gt(inverse_depth, best));
            if (hn::AllFalse(f, before)) continue;
            if (surface == nullptr) {
                Vec3 corners[3];
                for (int k = 0; k < 3; ++k) {
                    const int v = leaf.corner[k][i];
                    corners[k] = {leaf.x[v], leaf.y[v], leaf.z[v]};
                }
                surface = new (room) LayerSurface(scene, instance, triangle, corners, view.view);
            }
            const VF alpha = coverage(*surface, before, s, i, e, inverse_depth, squared_length(rays, x, y));
            const MF shows = hn::And(before, hn::Ge(alpha, hn::Set(f, kAlphaStep)));
            const MF opaque = hn::And(shows, hn::Gt(alpha, hn::Set(f, 1.0f - kAlphaStep)));
            alignas(64) float alphas[16], depths[16];
            hn::Store(hn::IfThenElse(opaque, hn::Set(f, 1.0f), alpha), f, alphas);
            hn::Store(hn::Div(hn::Set(f, 1.0f), inverse_depth), f, depths);
            for (std::uint32_t left = bits_of(shows); left != 0; left &= left - 1) {
                const int lane = std::countr_zero(left);
                if (found.count < found.out.size())
                    found.out[found.count] = {
                        first_id + instance, triangle, depths[lane], alphas[lane],
                        std::uint32_t((row - found.first_row) * kTileSize + chunk + lane - found.first_column)};
                ++found.count;
            }
            if (hn::AllFalse(f, opaque)) continue;
            hn::Store(hn::IfThenElse(opaque, inverse_depth, best), f, best_at);
            tile.first_changed = std::min(tile.first_changed, row);
            tile.last_changed = std::max(tile.last_changed, row);
        }
    }
}

HWY_NOINLINE void collect_leaf(const scene::StaticScene& scene, const BeamView& view, const AlphaRays& rays,
                               const BvhLeaf& leaf, std::uint32_t blended, std::uint32_t instance,
                               std::uint32_t first_id, const Linear (&xyw)[3], Tile& tile, Found& found) {
    LeafScratch s;
    const bool projected = transform_vertices(leaf, xyw, s);
    std::uint32_t bits = 0;
    for (int first = 0; first < leaf.triangle_count; first += kLanes) {
        if ((blended >> first & ((1u << kLanes) - 1u)) == 0) continue;
        bits |= projected ? set_up<true, true, false, false>(leaf, first, tile, s)
                          : set_up<true, false, false, false>(leaf, first, tile, s);
    }
    for (bits &= blended; bits != 0; bits &= bits - 1)
        collect(scene, view, rays, leaf, s, std::countr_zero(bits), instance, first_id, tile, found);
    if (tile.first_changed <= tile.last_changed) find_farthest(tile);
}

// Where each pixel's search ends.
HWY_INLINE void bound_pixels(const AlphaRays& rays, const TileRequest& request, const VisibilityBuffer& visible,
                             Tile& tile) {
    constexpr float kNearer = 1.000002f;  // what is seen may be the solid part of a layer: it is not found again
    const VF per_within = hn::Set(f, 1.0f / rays.blend_within_m);
    const int first_column = request.x % kBeamSize, first_row = request.y % kBeamSize;
    for (int row = 0; row < kTileSize; ++row) {
        const float* depth_at = visible.depth.data() + visible.index(request.x, request.y + row);
        const VF y = hn::Set(f, float(first_row + row) - kHalf);
        for (int chunk = 0; chunk < kTileSize; chunk += kLanes) {
            float* best = tile.best + (first_row + row) * kRowStride + first_column + chunk;
            const VF seen = hn::Div(hn::Set(f, kNearer), hn::LoadU(f, depth_at + chunk));
            const VF x = hn::Iota(f, float(first_column + chunk) - kHalf);
            const VF within = hn::Mul(hn::Sqrt(squared_length(rays, x, y)), per_within);
            hn::Store(hn::Max(hn::Max(seen, within), hn::Load(f, best)), f, best);
        }
    }
    tile.first_changed = first_row;
    tile.last_changed = first_row + kTileSize - 1;
    find_farthest(tile);
}

}  // namespace

std::size_t FindLayers(const LayerScene& layers, const BeamView& view, const TileRequest& request,
                       const VisibilityBuffer& visible, std::span<Layer> out) {
    Found found{out, request.x % kBeamSize, request.y % kBeamSize};
    const BeamRequest square = beam_request_of(request);
    Tile tile;
    std::uint32_t rows[kBeamSize];
    if (!begin_tile(view.view, square, rows, tile)) return 0;
    const AlphaRays rays = view.alpha_rays(square.x, square.y);
    bound_pixels(rays, request, visible, tile);

    const DMat3 tile_from_world = view.tile_from_world(square.x, square.y);
    const auto linears = [&](Linear(&xyw)[3], const DMat3& world_from_space, const WorldPos& origin) {
        const DVec3 offset = origin - view.view.position;
        for (int row = 0; row < 3; ++row) xyw[row] = linear_of(tile_from_world, row, world_from_space, offset);
    };
    std::uint64_t nodes_visited = 0;
    const auto search_instance = [&](const scene::StaticScene& scene, std::uint32_t id, std::uint32_t first_id) {
        const scene::Instance& instance = scene.instances[id];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        if ((mesh.material_flags & scene::kMaterialBlend) == 0 || mesh.node_count == 0) return;
        const BvhNode* nodes = scene.mesh_nodes.data() + mesh.first_node;
        const BvhLeaf* leaves = scene.mesh_leaves.data() + mesh.first_leaf;
        const std::uint16_t* children = layers.index.mesh_children.data() + mesh.first_node;
        const std::uint16_t* triangles = layers.index.leaf_triangles.data() + mesh.first_leaf;
        Linear xyw[3];
        linears(xyw, DMat3(instance.world_from_mesh), instance.position);
        const Beam beam = make_beam(xyw, reach_of(mesh.bounds.low, mesh.bounds.high), tile);
        walk(
            nodes, beam, tile, nodes_visited,
            [&](std::uint32_t child) {
                if (child & kBvhLeafBit)
                    prefetch(leaves + (child & ~kBvhLeafBit));
                else
                    prefetch(nodes + child);
            },
            [&](std::uint32_t leaf) {
                collect_leaf(scene, view, rays, leaves[leaf], triangles[leaf], id, first_id, xyw, tile, found);
            },
            [&](std::uint32_t node) { return std::uint32_t(children[node]); });
    };
    const auto search = [&](const scene::StaticScene& scene, std::uint32_t first_id, auto&& children_of) {
        if (scene.instance_nodes.empty()) return;
        Linear xyw[3];
        linears(xyw, DMat3(1.0), scene.origin);
        const Vec3 reach = reach_of(Vec3(scene.bounds.low - scene.origin), Vec3(scene.bounds.high - scene.origin));
        const Beam beam = make_beam(xyw, reach, tile);
        walk(
            scene.instance_nodes.data(), beam, tile, nodes_visited, [](std::uint32_t) {},
            [&](std::uint32_t id) { search_instance(scene, id, first_id); }, children_of);
    };
    if (!layers.index.instance_children.empty())
        search(layers.scene, 0,
               [&](std::uint32_t node) { return std::uint32_t(layers.index.instance_children[node]); });
    if (layers.dynamic != nullptr) search(*layers.dynamic, std::uint32_t(layers.scene.instances.size()), AllChildren{});

    // What was found before something opaque nearer than it.
    if (found.count > out.size()) return found.count;
    const auto hidden = [&](const Layer& layer) {
        const std::uint32_t row = layer.pixel / kTileSize, column = layer.pixel % kTileSize;
        const auto at = (std::uint32_t(found.first_row) + row) * std::uint32_t(kRowStride) +
                        std::uint32_t(found.first_column) + column;
        return 1.0f / layer.depth < tile.best[at] * (1.0f - 1e-6f);
    };
    return std::size_t(std::remove_if(out.begin(), out.begin() + std::ptrdiff_t(found.count), hidden) - out.begin());
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
namespace beam {
HWY_EXPORT(FindLayers);
}

std::size_t find_layers(const LayerScene& scene, const beam::BeamView& view, const TileRequest& request,
                        const VisibilityBuffer& visible, std::span<Layer> out) {
    using namespace beam;
    return HWY_DYNAMIC_DISPATCH(FindLayers)(scene, view, request, visible, out);
}

}  // namespace ff::farfield
#endif
