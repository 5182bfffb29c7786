// A square of 32 x 32 pixels at once: its beam walks the instances' hierarchy and each mesh's, front to back, against
// its planes and the farthest depth that it still has; leaves are set up and culled a register of triangles at a time,
// survivors go through edge functions over the rows that they cover.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/beam_caster_tile.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <bit>

#include "engine/farfield/beam_caster.h"
#include "engine/farfield/beam_rows-inl.h"
#include "engine/farfield/beam_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

// What a see-through triangle is described by lies far from its leaf.
HWY_INLINE void prefetch_materials(const scene::StaticScene& scene, const BvhLeaf& leaf, std::uint32_t instance) {
    const scene::Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
    const std::size_t first = std::size_t(mesh.first_triangle) + leaf.first_triangle;
    __builtin_prefetch(&scene.triangle_materials[first]);
    // Lines, counted as if the leaf were full: how many it has is not worth a branch.
    constexpr std::size_t kLine = 64 / sizeof(std::uint32_t);
    const std::uint32_t* indices = &scene.indices[3 * first];
    for (std::size_t index = 0; index < 3 * BvhLeaf::kMaxTriangles; index += kLine) __builtin_prefetch(indices + index);
}

// So do the vertices of those of a leaf's triangles that are set.
HWY_INLINE void prefetch_attributes(const scene::StaticScene& scene, const BvhLeaf& leaf, std::uint32_t instance,
                                    std::uint32_t triangles) {
    const scene::Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
    const std::uint32_t* indices = &scene.indices[3 * (std::size_t(mesh.first_triangle) + leaf.first_triangle)];
    const scene::VertexAttributes* attributes = scene.attributes.data() + mesh.first_vertex;
    for (; triangles != 0; triangles &= triangles - 1) {
        const std::uint32_t* corners = indices + 3 * std::countr_zero(triangles);
        for (int k = 0; k < 3; ++k) __builtin_prefetch(attributes + corners[k]);
    }
}

// Asks memory for where the answers go: rows of an image lie too far apart for the processor to see them coming.
HWY_INLINE void prefetch_answers(const BeamRequest& request, VisibilityBuffer& out) {
    constexpr int kLine = 64 / sizeof(float);
    const int rows = std::min(kBeamSize, out.rows - int(request.y));
    const int columns = std::min(kBeamSize, out.stride - int(request.x));
    for (int row = 0; row < rows; ++row) {
        const std::size_t first = out.index(request.x, request.y + row);
        for (std::size_t at = first; at < first + std::size_t(columns); at += kLine) {
            __builtin_prefetch(&out.depth[at], 1);
            __builtin_prefetch(&out.instance[at], 1);
            __builtin_prefetch(&out.triangle[at], 1);
        }
    }
}

template <bool kBehind>
HWY_NOINLINE void draw_leaf(const scene::StaticScene& scene, const BvhLeaf& leaf, std::uint32_t instance,
                            const Linear (&xyw)[3], const AlphaRays& rays, Tile& tile) {
    if (leaf.alpha_triangles != 0) prefetch_materials(scene, leaf, instance);
    LeafScratch s;
    const bool projected = transform_vertices(leaf, xyw, s);
    std::uint32_t bits = 0;
    // Registers wider than a direct block would need it twice over: they look up.
    const bool direct = kLanes <= BvhLeaf::kMaxDirect && leaf.triangle_count <= BvhLeaf::kMaxDirect;
    for (int first = 0; first < leaf.triangle_count; first += kLanes) {
        bits |= projected ? (direct ? set_up<true, true, true>(leaf, first, tile, s)
                                    : set_up<true, true, false>(leaf, first, tile, s))
                          : (direct ? set_up<true, false, true>(leaf, first, tile, s)
                                    : set_up<true, false, false>(leaf, first, tile, s));
    }
    if ((bits & leaf.alpha_triangles) != 0) prefetch_attributes(scene, leaf, instance, bits & leaf.alpha_triangles);
    for (; bits != 0; bits &= bits - 1) {
        const int i = std::countr_zero(bits);
        const std::uint32_t triangle = leaf.first_triangle + std::uint32_t(i);
        if (HWY_UNLIKELY((leaf.alpha_triangles >> i) & 1)) {
            AlphaDraw alpha{scene, instance, triangle, rays, leaf, i, {}};
            draw<true, kBehind>(s, i, instance, triangle, tile, &alpha);
        } else {
            draw<false, kBehind>(s, i, instance, triangle, tile, nullptr);
        }
    }
    if (tile.changed_cells != 0) {
        find_farthest(tile, tile.changed_cells);
        tile.changed_cells = 0;
    }
}

// Makes the tile show only what lies beyond a plane.
// @return false where none of its rays meets the plane
bool begin_behind(const DepthPlane& plane, const AlphaRays& rays, Tile& tile) {
    tile.behind_x = plane.of_u * rays.u_step;
    tile.behind_y = plane.of_v * rays.v_step;
    tile.behind_c = plane.of_u * rays.u_middle + plane.of_v * rays.v_middle + plane.level;
    const float most = tile.behind_c + kHalf * (std::abs(tile.behind_x) + std::abs(tile.behind_y));
    if (!(most > 0.0f)) return false;
    tile.begin = std::max(tile.begin, 0.9999f / most);
    return true;
}

}  // namespace

void CastTile(const scene::StaticScene& scene, const BeamView& view, const BeamRequest& request, VisibilityBuffer& out,
              CastCost& cost) {
    Tile tile;
    std::uint32_t rows[kBeamSize];
    prefetch_answers(request, out);
    if (!begin_tile(view.view, request, rows, tile)) return;
    tile.begin = request.begin;
    for (const std::uint32_t row : rows) cost.rays += std::uint64_t(std::popcount(row));

    const AlphaRays rays = view.alpha_rays(request.x, request.y);
    const bool is_behind = request.behind != nullptr;
    if (is_behind && !begin_behind(*request.behind, rays, tile)) return write_tile(tile, request, rows, out);
    const DMat3 tile_from_world = view.tile_from_world(request.x, request.y);
    const auto linears = [&](Linear(&xyw)[3], const DMat3& world_from_space, const WorldPos& origin) {
        const DVec3 offset = origin - view.view.position;
        for (int row = 0; row < 3; ++row) xyw[row] = linear_of(tile_from_world, row, world_from_space, offset);
    };
    const auto draw_instance = [&](std::uint32_t id) {
        const scene::Instance& instance = scene.instances[id];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        const BvhNode* nodes = scene.mesh_nodes.data() + mesh.first_node;
        prefetch(nodes);
        const BvhLeaf* leaves = scene.mesh_leaves.data() + mesh.first_leaf;
        Linear xyw[3];
        linears(xyw, DMat3(instance.world_from_mesh), instance.position);
        const Beam beam = make_beam(xyw, reach_of(mesh.bounds.low, mesh.bounds.high), tile);
        walk(
            nodes, beam, tile, cost.nodes,
            [&](std::uint32_t child) {
                if (child & kBvhLeafBit)
                    prefetch(leaves + (child & ~kBvhLeafBit));
                else
                    prefetch(nodes + child);
            },
            [&](std::uint32_t leaf) {
                cost.triangles += leaves[leaf].triangle_count;
                if (HWY_UNLIKELY(is_behind))
                    draw_leaf<true>(scene, leaves[leaf], id, xyw, rays, tile);
                else
                    draw_leaf<false>(scene, leaves[leaf], id, xyw, rays, tile);
            });
    };
    if (!scene.instance_nodes.empty()) {
        Linear xyw[3];
        linears(xyw, DMat3(1.0), scene.origin);
        const Vec3 reach = reach_of(Vec3(scene.bounds.low - scene.origin), Vec3(scene.bounds.high - scene.origin));
        const Beam beam = make_beam(xyw, reach, tile);
        walk(
            scene.instance_nodes.data(), beam, tile, cost.nodes,
            [&](std::uint32_t child) {
                if (child & kBvhLeafBit)
                    prefetch(scene.instances.data() + (child & ~kBvhLeafBit));
                else
                    prefetch(scene.instance_nodes.data() + child);
            },
            draw_instance);
    }
    write_tile(tile, request, rows, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::beam {
HWY_EXPORT(CastTile);

void cast_tile(const scene::StaticScene& scene, const BeamView& view, const BeamRequest& request, VisibilityBuffer& out,
               CastCost& cost) {
    HWY_DYNAMIC_DISPATCH(CastTile)(scene, view, request, out, cost);
}
}  // namespace ff::farfield::beam
#endif
