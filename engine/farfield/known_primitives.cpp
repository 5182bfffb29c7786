// Candidates are gathered eight at a time into the layout of a direct leaf (scene/bvh.h), each lane with its own
// instance's transformation, and drawn as the tile caster draws its leaves.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/known_primitives.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "engine/farfield/beam_rows-inl.h"
#include "engine/farfield/known_primitives.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

constexpr int kBlock = BvhLeaf::kMaxDirect;
constexpr int kFilled = std::max(kBlock, kLanes);  // registers wider than a block repeat its last triangle

// Up to eight triangles of any instances.
struct alignas(64) Block {
    float linear[3][4][kFilled];    // the lanes' Linears: X W, Y W, W; x y z c
    float position[3][3][kFilled];  // corner, axis; mesh space
    std::uint32_t alpha = 0;        // bit per triangle that is masked or blended
};

HWY_INLINE bool is_see_through(const scene::StaticScene& scene, const scene::Mesh& mesh, std::size_t triangle) {
    constexpr std::uint32_t kSeeThrough = scene::kMaterialAlphaMask | scene::kMaterialBlend;
    if ((mesh.material_flags & kSeeThrough) == 0) return false;
    return (scene.materials[scene.triangle_materials[triangle]].flags & kSeeThrough) != 0;
}

// Transforms of the instances that came last: a tile's candidates alternate between a few.
class InstanceLinears {
  public:
    InstanceLinears(const scene::StaticScene& scene, const BeamView& view, const TileRequest& tile)
        : scene_(scene), position_(view.view.position), tile_from_world_(view.tile_from_world(tile.x, tile.y)) {}

    const Linear (&of(std::uint32_t id))[3] {
        Entry& entry = entries_[id % kEntries];
        if (id == entry.instance) return entry.xyw;
        const scene::Instance& instance = scene_.instances[id];
        const DVec3 offset = instance.position - position_;
        for (int row = 0; row < 3; ++row)
            entry.xyw[row] = linear_of(tile_from_world_, row, DMat3(instance.world_from_mesh), offset);
        entry.instance = id;
        return entry.xyw;
    }

  private:
    static constexpr std::uint32_t kEntries = 16;
    struct Entry {
        std::uint32_t instance = kSkyInstance;
        Linear xyw[3]{};
    };

    const scene::StaticScene& scene_;
    WorldPos position_;
    DMat3 tile_from_world_;
    Entry entries_[kEntries];
};

// Lanes beyond the last repeat it.
HWY_INLINE void fill(const scene::StaticScene& scene, std::span<const PrimitiveId> ids, InstanceLinears& linears,
                     Block& block) {
    block.alpha = 0;
    for (std::size_t lane = 0; lane < std::size_t(kFilled); ++lane) {
        const PrimitiveId id = ids[std::min(lane, ids.size() - 1)];
        const Linear(&xyw)[3] = linears.of(id.instance);
        for (int row = 0; row < 3; ++row) {
            block.linear[row][0][lane] = xyw[row].x;
            block.linear[row][1][lane] = xyw[row].y;
            block.linear[row][2][lane] = xyw[row].z;
            block.linear[row][3][lane] = xyw[row].c;
        }
        const scene::Mesh& mesh = scene.meshes[scene.instances[id.instance].mesh];
        const std::size_t triangle = std::size_t(mesh.first_triangle) + id.triangle;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3& p = scene.positions[mesh.first_vertex + scene.indices[3 * triangle + corner]];
            for (int axis = 0; axis < 3; ++axis) block.position[corner][axis][lane] = p[axis];
        }
        if (lane < ids.size() && is_see_through(scene, mesh, triangle)) block.alpha |= 1u << lane;
    }
}

// As transform_vertices, but each lane by its own instance.
HWY_INLINE bool transform(const Block& block, LeafScratch& s) {
    MF projected = hn::MaskFromVec(hn::BitCast(f, hn::Set(si, -1)));
    for (int corner = 0; corner < 3; ++corner) {
        const auto& p = block.position[corner];
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const VF x = hn::Load(f, p[0] + lane), y = hn::Load(f, p[1] + lane), z = hn::Load(f, p[2] + lane);
            const auto apply = [&](int row) {
                const auto load = [&](int term) { return hn::Load(f, block.linear[row][term] + lane); };
                return hn::MulAdd(load(0), x, hn::MulAdd(load(1), y, hn::MulAdd(load(2), z, load(3))));
            };
            projected = hn::And(projected, store_vertices(apply(0), apply(1), apply(2), s, corner * kBlock + lane));
        }
    }
    return hn::AllTrue(f, projected);
}

// A leaf's description of a block: what set_up reads beside the vertices.
HWY_INLINE BvhLeaf describe(std::size_t triangles) {
    BvhLeaf leaf;
    leaf.vertex_count = 3 * kBlock;
    leaf.triangle_count = std::uint16_t(triangles);
    for (int corner = 0; corner < 3; ++corner)
        for (int i = 0; i < 16; ++i) leaf.corner[corner][i] = std::uint8_t(corner * kBlock + std::min(i, kBlock - 1));
    return leaf;
}

HWY_INLINE void draw_block(const scene::StaticScene& scene, std::span<const PrimitiveId> ids, const Block& block,
                           float pixel_angle, Tile& tile) {
    constexpr bool kDirect = kLanes <= kBlock;
    LeafScratch s;
    const BvhLeaf leaf = describe(ids.size());
    const bool projected = transform(block, s);
    std::uint32_t bits = 0;
    for (int first = 0; first < leaf.triangle_count; first += kLanes)
        bits |= projected ? set_up<true, kDirect>(leaf, first, tile, s) : set_up<false, kDirect>(leaf, first, tile, s);
    for (; bits != 0; bits &= bits - 1) {
        const int i = std::countr_zero(bits);
        const PrimitiveId id = ids[std::size_t(i)];
        if ((block.alpha >> i) & 1) {
            AlphaDraw alpha{scene, id.instance, id.triangle, pixel_angle, {}, false, {}};
            for (int k = 0; k < 3; ++k)
                alpha.corners[k] = {block.position[k][0][i], block.position[k][1][i], block.position[k][2][i]};
            draw<true>(s, i, id.instance, id.triangle, tile, &alpha);
        } else {
            draw<false>(s, i, id.instance, id.triangle, tile, nullptr);
        }
    }
    if (tile.changed) find_farthest(tile);
}

// Moves the pixels that nothing covers from `rows` to `missed`.
HWY_INLINE void split_missed(const Tile& tile, std::uint16_t (&rows)[kTileSize], TileRequest& missed) {
    for (int row = 0; row < kTileSize; ++row) {
        std::uint32_t empty = 0;
        for (int chunk = 0; chunk < kTileSize; chunk += kLanes)
            empty |= bits_of(hn::Eq(hn::Load(f, tile.best + row * kTileSize + chunk), hn::Zero(f))) << chunk;
        missed.rows[row] = std::uint16_t(rows[row] & empty);
        rows[row] = std::uint16_t(rows[row] & ~empty);
    }
}

}  // namespace

void CastKnownTile(const scene::StaticScene& scene, const BeamView& view, const TileRequest& request,
                   std::span<const PrimitiveId> candidates, VisibilityBuffer& out, TileRequest& missed) {
    missed = {request.x, request.y, {}};
    Tile tile;
    std::uint16_t rows[kTileSize];
    if (!begin_tile(view.view, request, rows, tile)) return;
    InstanceLinears linears(scene, view, request);
    Block block;
    for (std::size_t first = 0; first < candidates.size(); first += std::size_t(kBlock)) {
        const auto ids = candidates.subspan(first, std::min(candidates.size() - first, std::size_t(kBlock)));
        fill(scene, ids, linears, block);
        draw_block(scene, ids, block, view.pixel_angle, tile);
    }
    split_missed(tile, rows, missed);
    write_tile(tile, request, rows, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
namespace beam {
HWY_EXPORT(CastKnownTile);
}

void PrimitiveSet::clear() {
    count_ = 0;
    slots_.fill(0);
}

void PrimitiveSet::add(std::uint32_t instance, std::uint32_t triangle) {
    if (instance == kSkyInstance || count_ == kCapacity) return;
    const PrimitiveId id{instance, triangle};
    if (count_ != 0 && ids_[count_ - 1] == id) return;
    const std::uint32_t hash = (instance * 0x9E3779B1u) ^ (triangle * 0x85EBCA77u);
    for (std::size_t slot = hash >> 21;; slot = (slot + 1) % slots_.size()) {
        if (slots_[slot] == 0) {
            ids_[count_++] = id;
            slots_[slot] = std::uint16_t(count_);
            return;
        }
        if (ids_[slots_[slot] - 1u] == id) return;
    }
}

void cast_known_tile(const scene::StaticScene& scene, const beam::BeamView& view, const TileRequest& request,
                     std::span<const PrimitiveId> candidates, VisibilityBuffer& out, TileRequest& missed) {
    using namespace beam;
    HWY_DYNAMIC_DISPATCH(CastKnownTile)(scene, view, request, candidates, out, missed);
}

}  // namespace ff::farfield
#endif
