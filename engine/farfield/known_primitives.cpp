// Candidates are gathered eight at a time into the layout of a direct leaf (scene/bvh.h), each lane with its own
// instance's transformation, and set up as the tile caster sets up its leaves. Where most of a tile is asked for, they
// are drawn as the tile caster draws them; where it is few pixels, these are packed into registers row by row, and a
// triangle tests those of its rows.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/known_primitives.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "engine/core/check.h"
#include "engine/farfield/beam_rows-inl.h"
#include "engine/farfield/known_block-inl.h"
#include "engine/farfield/known_primitives.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

// The pixels asked for, row by row, and what each has found so far; filled up to whole registers.
struct Pixels {
    static constexpr int kMost = kTileSize * kTileSize;
    int count = 0;
    int first_column, first_row;  // of the request, within the tile
    int first_of_row[kTileSize + 1];
    alignas(64) float x[kMost], y[kMost];  // tile space
    alignas(64) float best[kMost];         // 1/depth; 0: nothing; +inf beyond the last
    alignas(64) std::uint32_t instance[kMost];
    alignas(64) std::uint32_t triangle[kMost];
};

// Pixels asked for, within the image, and their bounds in `tile`; false when there are none.
HWY_INLINE bool begin_pixels(const PinholeView& view, const TileRequest& request, Pixels& pixels, Tile& tile) {
    pixels.first_column = request.x % kBeamSize;
    pixels.first_row = request.y % kBeamSize;
    const int columns = std::min(kTileSize, view.width - int(request.x));
    const int rows = std::min(kTileSize, view.height - int(request.y));
    std::uint32_t any_column = 0, any_row = 0;
    for (int row = 0; row < kTileSize; ++row) {
        pixels.first_of_row[row] = pixels.count;
        if (columns <= 0 || row >= rows) continue;
        const std::uint32_t bits = request.rows[row] & ((1u << columns) - 1u);
        any_column |= bits;
        any_row |= std::uint32_t(bits != 0) << row;
        for (std::uint32_t left = bits; left != 0; left &= left - 1) {
            pixels.x[pixels.count] = float(pixels.first_column + std::countr_zero(left)) - kHalf;
            pixels.y[pixels.count++] = float(pixels.first_row + row) - kHalf;
        }
    }
    pixels.first_of_row[kTileSize] = pixels.count;
    if (any_column == 0) return false;
    tile.first_column = float(pixels.first_column + std::countr_zero(any_column));
    tile.last_column = float(pixels.first_column + 31 - std::countl_zero(any_column));
    tile.first_row = float(pixels.first_row + std::countr_zero(any_row));
    tile.last_row = float(pixels.first_row + 31 - std::countl_zero(any_row));
    for (int at = 0; at < pixels.count; at += kLanes) {
        const auto asked = hn::FirstN(f, std::size_t(pixels.count - at));
        hn::Store(hn::IfThenElse(asked, hn::Zero(f), hn::Set(f, kInf)), f, pixels.best + at);
        hn::Store(hn::IfThenElseZero(asked, hn::Load(f, pixels.x + at)), f, pixels.x + at);
        hn::Store(hn::IfThenElseZero(asked, hn::Load(f, pixels.y + at)), f, pixels.y + at);
        hn::Store(hn::Set(ui, kSkyInstance), ui, pixels.instance + at);
        hn::Store(hn::Zero(ui), ui, pixels.triangle + at);
    }
    return true;
}

// draw() of beam_rows-inl.h for packed pixels.
template <bool kAlpha>
HWY_INLINE void draw_packed(const LeafScratch& s, int i, PrimitiveId id, Pixels& pixels, AlphaDraw* alpha) {
    const VF a0 = hn::Set(f, s.a[0][i]), a1 = hn::Set(f, s.a[1][i]), a2 = hn::Set(f, s.a[2][i]);
    const VF b0 = hn::Set(f, s.b[0][i]), b1 = hn::Set(f, s.b[1][i]), b2 = hn::Set(f, s.b[2][i]);
    const VF c0 = hn::Set(f, s.c[0][i]), c1 = hn::Set(f, s.c[1][i]), c2 = hn::Set(f, s.c[2][i]);
    const VF gx = hn::Set(f, s.gx[i]), gy = hn::Set(f, s.gy[i]), g0 = hn::Set(f, s.g0[i]);
    const VF low = hn::Set(f, s.low[i]), high = hn::Set(f, s.high[i]);
    const VF left = hn::Set(f, float(s.x0[i]) - kHalf), right = hn::Set(f, float(s.x1[i]) - kHalf);
    const VF upper = hn::Set(f, float(s.y0[i]) - kHalf), lower = hn::Set(f, float(s.y1[i]) - kHalf);
    const auto own_instance = hn::Set(ui, id.instance), own_triangle = hn::Set(ui, id.triangle);
    const int end = pixels.first_of_row[s.y1[i] - pixels.first_row + 1];
    for (int at = pixels.first_of_row[s.y0[i] - pixels.first_row] / kLanes * kLanes; at < end; at += kLanes) {
        const VF x = hn::Load(f, pixels.x + at), y = hn::Load(f, pixels.y + at);
        const VF e[3] = {hn::MulAdd(b0, y, hn::MulAdd(a0, x, c0)), hn::MulAdd(b1, y, hn::MulAdd(a1, x, c1)),
                         hn::MulAdd(b2, y, hn::MulAdd(a2, x, c2))};
        // Not-a-number (a sliver's plane) becomes `low`: x86's max returns its second operand then.
        const VF inverse_depth = hn::Min(hn::Max(hn::MulAdd(gy, y, hn::MulAdd(gx, x, g0)), low), high);
        const VF best = hn::Load(f, pixels.best + at);
        const MF within =
            hn::And(hn::And(hn::Ge(x, left), hn::Le(x, right)), hn::And(hn::Ge(y, upper), hn::Le(y, lower)));
        const MF inside = hn::And(within, hn::Ge(min3(e[0], e[1], e[2]), hn::Zero(f)));
        MF win = hn::And(inside, hn::Ge(inverse_depth, best));
        if (hn::AllFalse(f, win)) continue;
        const auto old_instance = hn::Load(ui, pixels.instance + at), old_triangle = hn::Load(ui, pixels.triangle + at);
        const auto smaller = hn::Or(hn::Lt(own_instance, old_instance),
                                    hn::And(hn::Eq(own_instance, old_instance), hn::Lt(own_triangle, old_triangle)));
        win = hn::And(win, hn::Or(hn::Gt(inverse_depth, best), hn::RebindMask(f, smaller)));
        if constexpr (kAlpha) win = opaque_lanes(win, *alpha, s, i, x, y, e, inverse_depth);
        const auto win_u = hn::RebindMask(ui, win);
        hn::Store(hn::IfThenElse(win, inverse_depth, best), f, pixels.best + at);
        hn::Store(hn::IfThenElse(win_u, own_instance, old_instance), ui, pixels.instance + at);
        hn::Store(hn::IfThenElse(win_u, own_triangle, old_triangle), ui, pixels.triangle + at);
    }
}

// Calls draw_one(scratch, lane, triangle, alpha or null) for the triangles that may win a pixel of the tile.
template <class DrawOne>
HWY_INLINE void draw_blocks(const scene::StaticScene& scene, const BeamView& view, const TileRequest& request,
                            std::span<const KnownTriangle> candidates, const Tile& tile, DrawOne&& draw_one) {
    constexpr bool kDirect = kLanes <= kBlock;
    InstanceLinears linears(scene, view, request);
    const BeamRequest square = beam_request_of(request);
    const AlphaRays rays = view.alpha_rays(square.x, square.y);
    Block block;
    LeafScratch s;
    for (std::size_t begin = 0; begin < candidates.size(); begin += std::size_t(kBlock)) {
        const auto triangles = candidates.subspan(begin, std::min(candidates.size() - begin, std::size_t(kBlock)));
        fill(triangles, linears, block);
        BvhLeaf leaf = describe(triangles.size());
        const bool projected = transform(block, s);
        std::uint32_t bits = 0;
        for (int first = 0; first < leaf.triangle_count; first += kLanes)
            bits |= projected ? set_up<false, true, kDirect>(leaf, first, tile, s)
                              : set_up<false, false, kDirect>(leaf, first, tile, s);
        for (; bits != 0; bits &= bits - 1) {
            const int i = std::countr_zero(bits);
            const KnownTriangle& triangle = triangles[std::size_t(i)];
            if ((block.alpha >> i) & 1) {
                for (int corner = 0; corner < 3; ++corner) {
                    const Vec3& p = triangle.corners[corner];
                    const int v = leaf.corner[corner][i];
                    leaf.x[v] = p.x, leaf.y[v] = p.y, leaf.z[v] = p.z;
                }
                AlphaDraw alpha{scene, triangle.id.instance, triangle.id.triangle, rays, leaf, i, {}};
                draw_one(s, i, triangle.id, &alpha);
            } else {
                draw_one(s, i, triangle.id, static_cast<AlphaDraw*>(nullptr));
            }
        }
    }
}

// Pixels that found something go to `out`, the others to `missed`.
HWY_INLINE void write_pixels(const Pixels& pixels, const TileRequest& request, VisibilityBuffer& out,
                             TileRequest& missed) {
    float* const depths = out.depth.data();
    std::uint32_t *const instances = out.instance.data(), *const triangles = out.triangle.data();
    for (int row = 0; row < kTileSize; ++row) {
        const std::size_t first = out.index(request.x, request.y + row);
        std::uint32_t empty = 0;
        for (int at = pixels.first_of_row[row]; at < pixels.first_of_row[row + 1]; ++at) {
            const int column = int(pixels.x[at] + kHalf) - pixels.first_column;
            if (pixels.best[at] == 0.0f) {
                empty |= 1u << column;
                continue;
            }
            const std::size_t to = first + std::size_t(column);
            depths[to] = 1.0f / pixels.best[at];
            instances[to] = pixels.instance[at];
            triangles[to] = pixels.triangle[at];
        }
        missed.rows[row] = std::uint16_t(empty);
    }
}

// The same for the rows of a whole tile.
HWY_INLINE void write_hits(const Tile& tile, const TileRequest& request, const BeamRequest& square,
                           const std::uint32_t (&rows)[kBeamSize], VisibilityBuffer& out, TileRequest& missed) {
    std::uint32_t hits[kBeamSize];
    const int first_column = request.x % kBeamSize, first_row = request.y % kBeamSize;
    for (int row = 0; row < kBeamSize; ++row) {
        hits[row] = 0;
        if (rows[row] == 0) continue;
        for (int chunk = 0; chunk < kBeamSize; chunk += kLanes)
            hits[row] |= bits_of(hn::Gt(hn::Load(f, tile.best + row * kRowStride + chunk), hn::Zero(f))) << chunk;
        hits[row] &= rows[row];
        missed.rows[row - first_row] = std::uint16_t((rows[row] & ~hits[row]) >> first_column);
    }
    write_tile(tile, square, hits, out);
}

}  // namespace

void CastKnownTile(const scene::StaticScene& scene, const BeamView& view, const TileRequest& request,
                   std::span<const KnownTriangle> candidates, VisibilityBuffer& out, TileRequest& missed) {
    missed = {request.x, request.y, {}};
    int asked = 0;
    for (const std::uint16_t row : request.rows) asked += std::popcount(row);
    Tile tile;  // its depths drop no candidate: they are too few
    constexpr int kManyPixels = 64;
    if (asked >= kManyPixels) {
        const BeamRequest square = beam_request_of(request);
        std::uint32_t rows[kBeamSize];
        if (!begin_tile(view.view, square, rows, tile)) return;
        draw_blocks(scene, view, request, candidates, tile,
                    [&](const LeafScratch& s, int i, PrimitiveId id, AlphaDraw* alpha) {
                        if (alpha != nullptr)
                            draw<true>(s, i, id.instance, id.triangle, tile, alpha);
                        else
                            draw<false>(s, i, id.instance, id.triangle, tile, nullptr);
                    });
        write_hits(tile, request, square, rows, out, missed);
        return;
    }
    Pixels pixels;
    if (!begin_pixels(view.view, request, pixels, tile)) return;
    draw_blocks(scene, view, request, candidates, tile,
                [&](const LeafScratch& s, int i, PrimitiveId id, AlphaDraw* alpha) {
                    if (alpha != nullptr)
                        draw_packed<true>(s, i, id, pixels, alpha);
                    else
                        draw_packed<false>(s, i, id, pixels, nullptr);
                });
    write_pixels(pixels, request, out, missed);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
namespace beam {
HWY_EXPORT(CastKnownTile);
}

namespace {

bool is_see_through(const scene::StaticScene& scene, const scene::Mesh& mesh, std::size_t triangle) {
    constexpr std::uint32_t kSeeThrough = scene::kMaterialAlphaMask | scene::kMaterialBlend;
    if ((mesh.material_flags & kSeeThrough) == 0) return false;
    return (scene.materials[scene.triangle_materials[triangle]].flags & kSeeThrough) != 0;
}

}  // namespace

void PrimitiveSet::start(std::span<PrimitiveId> room) {
    FF_CHECK(room.size() >= kCapacity, "room for {} primitives, {} needed", room.size(), kCapacity);
    for (std::size_t i = 0; i < count_; ++i) slots_[slot_of_[i]] = 0;
    count_ = 0;
    ids_ = room;
}

void fetch_triangles(const scene::StaticScene& scene, std::span<const PrimitiveId> ids, std::span<KnownTriangle> out) {
    FF_CHECK(out.size() >= ids.size(), "{} triangles for {} primitives", out.size(), ids.size());
    // From instance to mesh to indices to corners each step waits for the one before: all take one step together.
    constexpr std::size_t kTogether = 64;
    const scene::Mesh* meshes[kTogether];
    const std::uint32_t* corners[kTogether];
    for (std::size_t first = 0; first < ids.size(); first += kTogether) {
        const std::size_t count = std::min(kTogether, ids.size() - first);
        for (std::size_t i = 0; i < count; ++i) __builtin_prefetch(&scene.instances[ids[first + i].instance].mesh);
        for (std::size_t i = 0; i < count; ++i) {
            meshes[i] = &scene.meshes[scene.instances[ids[first + i].instance].mesh];
            __builtin_prefetch(meshes[i]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t triangle = std::size_t(meshes[i]->first_triangle) + ids[first + i].triangle;
            corners[i] = &scene.indices[3 * triangle];
            __builtin_prefetch(corners[i]);
            __builtin_prefetch(&scene.triangle_materials[triangle]);
        }
        for (std::size_t i = 0; i < count; ++i)
            for (int corner = 0; corner < 3; ++corner)
                __builtin_prefetch(&scene.positions[meshes[i]->first_vertex + corners[i][corner]]);
        for (std::size_t i = 0; i < count; ++i) {
            KnownTriangle& triangle = out[first + i];
            triangle.id = ids[first + i];
            for (int corner = 0; corner < 3; ++corner)
                triangle.corners[corner] = scene.positions[meshes[i]->first_vertex + corners[i][corner]];
            triangle.is_see_through =
                is_see_through(scene, *meshes[i], std::size_t(meshes[i]->first_triangle) + triangle.id.triangle);
            if (!triangle.is_see_through) continue;
            // The alpha test will want their texture coordinates.
            for (int corner = 0; corner < 3; ++corner)
                __builtin_prefetch(&scene.attributes[meshes[i]->first_vertex + corners[i][corner]]);
        }
    }
}

void cast_known_tile(const scene::StaticScene& scene, const beam::BeamView& view, const TileRequest& request,
                     std::span<const KnownTriangle> candidates, VisibilityBuffer& out, TileRequest& missed) {
    using namespace beam;
    HWY_DYNAMIC_DISPATCH(CastKnownTile)(scene, view, request, candidates, out, missed);
}

}  // namespace ff::farfield
#endif
